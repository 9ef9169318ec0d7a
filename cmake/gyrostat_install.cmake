# SPDX-License-Identifier: MIT
# find_package(gyrostat COMPONENTS core flight truth host): one export a layer, relocatable.
include(CMakePackageConfigHelpers)

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/gyrostat)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/gyrostat-config.cmake.in
                              ${PROJECT_BINARY_DIR}/gyrostat-config.cmake INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gyrostat-config-version.cmake COMPATIBILITY SameMinorVersion
                                 ARCH_INDEPENDENT)
install(FILES ${PROJECT_BINARY_DIR}/gyrostat-config.cmake ${PROJECT_BINARY_DIR}/gyrostat-config-version.cmake
        DESTINATION ${config_dir} COMPONENT core)
foreach(layer core flight truth host)
  if(TARGET gyrostat_${layer})
    install(EXPORT gyrostat-${layer} NAMESPACE gyrostat:: FILE gyrostat-${layer}.cmake DESTINATION ${config_dir}
            COMPONENT ${layer})
  endif()
endforeach()
