# SPDX-License-Identifier: MIT
# cmake -D BUILD=<build tree> -D PREFIX=<where> -D COMPONENTS=<list or empty: all> -P install.cmake
# Installs into another folder first and moves it: what is installed must not know where it was.
file(REMOVE_RECURSE ${PREFIX} ${PREFIX}.first)
if(COMPONENTS)
  foreach(component IN LISTS COMPONENTS)
    execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX}.first --component ${component}
                    COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
else()
  execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX}.first COMMAND_ERROR_IS_FATAL ANY)
endif()
file(RENAME ${PREFIX}.first ${PREFIX})
file(GLOB_RECURSE config ${PREFIX}/*.cmake)
foreach(file IN LISTS config)
  file(STRINGS ${file} absolute REGEX "${BUILD}|${PREFIX}")
  if(absolute)
    message(FATAL_ERROR "${file} names a folder of the build:\n${absolute}")
  endif()
endforeach()
