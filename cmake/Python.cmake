# Whether the Python module can be built: sets the default of SURFIT_BUILD_PYTHON.
# Debian's Python is the one that Debian's pybind11 and numpy are for; another may stand before it
# in PATH.
if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "Python that the module is built for")
endif()
find_package(Python3 QUIET COMPONENTS Interpreter Development.Module NumPy)
find_package(pybind11 2.10 QUIET CONFIG)
set(python_default OFF)
# A sanitized module would need the sanitizer's run-time library in Python itself.
if(Python3_FOUND AND pybind11_FOUND AND PROJECT_IS_TOP_LEVEL AND NOT SURFIT_SANITIZE)
  set(python_default ON)
endif()
option(SURFIT_BUILD_PYTHON "Build the Python module" ${python_default})
if(SURFIT_BUILD_PYTHON)
  find_package(Python3 REQUIRED COMPONENTS Interpreter Development.Module NumPy)
  find_package(pybind11 2.10 REQUIRED CONFIG)
endif()
