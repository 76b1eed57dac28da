# SPDX-License-Identifier: MIT
# Sets MAXLOGDET_PYTHON_MISSING to the Debian packages that the Python module lacks. If it is empty, Python3_EXECUTABLE
# is the module's interpreter, pybind11_add_module can be called, and MAXLOGDET_PYTHON_SITE_DIR is that interpreter's
# folder of packages, relative to a prefix.
#
# A machine may have several interpreters, and NumPy for only one of them: a python3 of pyenv comes first in the path,
# and apt-get installs for /usr/bin/python3. Unless -DPython3_EXECUTABLE names one, the first that can import NumPy is
# used, of that in the path and then the system's. It determines headers, the module's suffix and tests.
macro(maxlogdet_find_python)
  set(MAXLOGDET_PYTHON_MISSING)
  if(NOT Python3_EXECUTABLE)
    unset(Python3_EXECUTABLE)
    unset(Python3_EXECUTABLE CACHE)
    find_program(MAXLOGDET_PYTHON_IN_PATH python3)
    mark_as_advanced(MAXLOGDET_PYTHON_IN_PATH)
    foreach(candidate IN ITEMS ${MAXLOGDET_PYTHON_IN_PATH} /usr/bin/python3 /usr/local/bin/python3)
      execute_process(COMMAND ${candidate} -c "import numpy" RESULT_VARIABLE no_numpy OUTPUT_QUIET ERROR_QUIET)
      if(no_numpy STREQUAL "0")
        set(Python3_EXECUTABLE ${candidate} CACHE FILEPATH "The interpreter that the Python module is for")
        break()
      endif()
    endforeach()
  endif()
  if(Python3_EXECUTABLE)
    execute_process(COMMAND ${Python3_EXECUTABLE} -c "import numpy" RESULT_VARIABLE no_numpy OUTPUT_QUIET ERROR_QUIET)
  endif()
  if(NOT Python3_EXECUTABLE OR NOT no_numpy STREQUAL "0")
    list(APPEND MAXLOGDET_PYTHON_MISSING python3-numpy)
  endif()

  if(CMAKE_VERSION VERSION_LESS 3.18)
    find_package(Python3 3.6 QUIET COMPONENTS Interpreter Development)
  else()
    find_package(Python3 3.6 QUIET COMPONENTS Interpreter Development.Module)
  endif()
  if(NOT Python3_FOUND)
    list(APPEND MAXLOGDET_PYTHON_MISSING python3-dev)
  else()
    find_package(pybind11 2.10 QUIET)
  endif()
  if(NOT pybind11_FOUND)
    list(APPEND MAXLOGDET_PYTHON_MISSING pybind11-dev)
  endif()

  if(NOT MAXLOGDET_PYTHON_MISSING)
    execute_process(
      COMMAND ${Python3_EXECUTABLE} -c
              "import sysconfig; print('/'.join(sysconfig.get_path('platlib').split('/')[-3:]))"
      OUTPUT_VARIABLE MAXLOGDET_PYTHON_SITE_DIR OUTPUT_STRIP_TRAILING_WHITESPACE)
  endif()
endmacro()
