# Whether the Python module is built, decided anew at each configuration.
set(SURFIT_BUILD_PYTHON AUTO CACHE STRING
    "Build the Python module: ON, OFF, or AUTO: where Python, pybind11 and NumPy are found")
# Debian's Python is the one that Debian's pybind11 and numpy are for; another may stand before it
# in PATH.
if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "Python that the module is built for")
endif()
find_package(Python3 QUIET COMPONENTS Interpreter Development.Module NumPy)
find_package(pybind11 2.10 QUIET CONFIG)
if(SURFIT_BUILD_PYTHON STREQUAL "AUTO")
  # A sanitized module would need the sanitizer's run-time library in Python itself.
  if(Python3_FOUND AND pybind11_FOUND AND PROJECT_IS_TOP_LEVEL AND NOT SURFIT_SANITIZE)
    set(SURFIT_BUILD_PYTHON ON)
  else()
    set(SURFIT_BUILD_PYTHON OFF)
  endif()
elseif(SURFIT_BUILD_PYTHON)
  find_package(Python3 REQUIRED COMPONENTS Interpreter Development.Module NumPy)
  find_package(pybind11 2.10 REQUIRED CONFIG)
endif()
