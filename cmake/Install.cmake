# Install and export, so that find_package(surfit) works from another project.
include(CMakePackageConfigHelpers)
set(SURFIT_CMAKE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/surfit")
install(TARGETS surfit EXPORT surfit-targets FILE_SET HEADERS)
install(TARGETS surfit_cost_functions EXPORT surfit-targets
  FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/surfit")
install(EXPORT surfit-targets NAMESPACE surfit:: DESTINATION "${SURFIT_CMAKE_DIR}")
configure_package_config_file(cmake/surfit-config.cmake.in "${PROJECT_BINARY_DIR}/surfit-config.cmake"
  INSTALL_DESTINATION "${SURFIT_CMAKE_DIR}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/surfit-config-version.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/surfit-config.cmake" "${PROJECT_BINARY_DIR}/surfit-config-version.cmake"
  DESTINATION "${SURFIT_CMAKE_DIR}")
