# SPDX-License-Identifier: MIT

# The C++ runtime, which a static C++ library needs and a C compiler does not link: the libraries that the C++ compiler
# links by default.
set(maxlogdet_cxx_runtime ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
list(FILTER maxlogdet_cxx_runtime INCLUDE REGEX "^(stdc\\+\\+|c\\+\\+|c\\+\\+abi|m)$")
list(REMOVE_DUPLICATES maxlogdet_cxx_runtime)
if(NOT maxlogdet_cxx_runtime)
  set(maxlogdet_cxx_runtime stdc++ m)
endif()

# Installs cmake/NAME.pc.in. The prefix in a .pc file is relative to the file itself, so that the installed tree can be
# moved.
function(maxlogdet_install_pkg_config name)
  file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  file(RELATIVE_PATH pc_libdir ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_LIBDIR})
  file(RELATIVE_PATH pc_includedir ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_INCLUDEDIR})
  list(TRANSFORM maxlogdet_cxx_runtime PREPEND -l OUTPUT_VARIABLE pc_cxx_runtime)
  list(JOIN pc_cxx_runtime " " pc_cxx_runtime)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
