# SPDX-License-Identifier: MIT
# Run by CPack between installing and packing: makes /usr/share/doc as Debian requires it, named after the package, with
# its copyright file and a changelog. The date is SOURCE_DATE_EPOCH, if that is set.
set(docs ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/share/doc)
set(own ${docs}/${CPACK_PACKAGE_NAME})
file(RENAME ${docs}/maxlogdet ${own})
file(REMOVE ${own}/LICENSE)  # the copyright file holds it
configure_file(${CPACK_MAXLOGDET_COPYRIGHT} ${own}/copyright COPYONLY)

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${own}/changelog
"maxlogdet (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium

  * Version ${CPACK_PACKAGE_VERSION}.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
execute_process(COMMAND gzip -9n ${own}/changelog RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "gzip could not compress the changelog: ${status}")
endif()
