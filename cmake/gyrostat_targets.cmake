# SPDX-License-Identifier: MIT
# What all our targets share: nothing here reaches a user of the libraries.
include_guard(GLOBAL)
include(GNUInstallDirs)

if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_VERIFY_INTERFACE_HEADER_SETS ON)  # target all_verify_interface_header_sets: each header compiles alone
  find_program(GYROSTAT_CCACHE ccache)
  mark_as_advanced(GYROSTAT_CCACHE)
  if(GYROSTAT_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    # Without this sloppiness ccache refuses every file that uses a precompiled header. It takes the headers of a file from the
    # compiler's list of them (Ninja and Makefiles have one written), so that what is not found is not preprocessed first.
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_DEPEND=1
                                    CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} ${GYROSTAT_CCACHE})
  endif()
endif()

# gcc looks for garbage each time its heap has grown, and marks every template: 4 to 11 % of its time here. Less often it takes up
# to a third more memory, so that is for tests, and not for libraries as a user builds them.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(gyrostat_less_garbage --param=ggc-min-expand=200 --param=ggc-min-heapsize=1000000)
endif()

if(GYROSTAT_SANITIZE)
  add_compile_options(${gyrostat_less_garbage})
  # Left out: what the address sanitizer reports anyway. Those checks stand at every access and cost compile time. Preset asan
  # leaves out two more, a third of it: alignment, and pointers that wrap, whose access the address sanitizer reports. The module
  # (asan-python) and the fuzz target have both.
  add_compile_options(-fsanitize=${GYROSTAT_SANITIZE} -fno-sanitize=${GYROSTAT_SANITIZE_NOT} -fno-sanitize-recover=all
                      -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${GYROSTAT_SANITIZE})
endif()

# Flags of our own compiled targets. Warnings become errors by preset (CMAKE_COMPILE_WARNING_AS_ERROR), never for a user.
# -ffp-contract=off: the same bits whether or not the machine has fused multiply-add.
# Hardened: stack protector everywhere, checked calls of the C library where they are optimised and no sanitizer looks.
function(gyrostat_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow -ffp-contract=off -fstack-protector-strong)
  if(NOT GYROSTAT_SANITIZE)
    target_compile_options(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE> $<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=2>)
  endif()
  if(GYROSTAT_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND GYROSTAT_CCACHE)
    target_compile_options(${target} PRIVATE -fpch-preprocess)
  endif()
  if(GYROSTAT_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)  # which takes a file inside another for a header
  endif()
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
endfunction()

# gyrostat_layer(<name> HEADERS <paths below this folder>... [SOURCES <paths>...])
# Target gyrostat_<name>, alias gyrostat::<name>, include root: this folder. Header-only without SOURCES.
function(gyrostat_layer name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "HEADERS;SOURCES")
  set(target gyrostat_${name})
  if(arg_SOURCES)
    set(scope PUBLIC)
    add_library(${target} STATIC ${arg_SOURCES})
    gyrostat_flags(${target})
    target_compile_options(${target} PRIVATE -Wsign-conversion)  # as flags of a user may ask of our headers; -Wpedantic would lose the precompiled one
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)  # the Python module links them
    gyrostat_precompile(${target})
    set_target_properties(${target} PROPERTIES UNITY_BUILD ${GYROSTAT_UNITY} UNITY_BUILD_BATCH_SIZE 5)
  else()
    set(scope INTERFACE)
    add_library(${target} INTERFACE)
  endif()
  add_library(gyrostat::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_sources(${target} ${scope} FILE_SET HEADERS BASE_DIRS ${CMAKE_CURRENT_SOURCE_DIR} FILES ${arg_HEADERS})
  install(TARGETS ${target} EXPORT gyrostat-${name} COMPONENT ${name}
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

# One precompiled Eigen serves all libraries; parsing it costs more than most of our files.
function(gyrostat_precompile target)
  if(NOT GYROSTAT_PRECOMPILE)
    return()
  endif()
  if(NOT TARGET gyrostat_eigen_pch)
    set(empty ${PROJECT_BINARY_DIR}/eigen_pch.cpp)
    file(CONFIGURE OUTPUT ${empty} CONTENT "// compiles the precompiled header\n")
    add_library(gyrostat_eigen_pch OBJECT ${empty})
    target_link_libraries(gyrostat_eigen_pch PRIVATE gyrostat_core)  # Eigen as all our code compiles it
    target_compile_features(gyrostat_eigen_pch PRIVATE cxx_std_20)
    gyrostat_flags(gyrostat_eigen_pch)
    set_target_properties(gyrostat_eigen_pch PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_precompile_headers(gyrostat_eigen_pch PRIVATE <Eigen/Dense>)
  endif()
  target_precompile_headers(${target} REUSE_FROM gyrostat_eigen_pch)
endfunction()
