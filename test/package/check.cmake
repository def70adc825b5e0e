# SPDX-License-Identifier: BSD-3-Clause
# Installs the build into a fresh prefix, configures and builds the consumer against it, and runs it.
#   cmake -D BUILD=… -D SOURCE=… -D WORK=… -D GENERATOR=… -P check.cmake
file(REMOVE_RECURSE ${WORK})
function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${code}:\n${out}")
  endif()
endfunction()

step(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
step(${CMAKE_COMMAND} -S ${SOURCE}/consumer -B ${WORK}/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix)
step(${CMAKE_COMMAND} --build ${WORK}/build)
execute_process(COMMAND ${WORK}/build/consumer RESULT_VARIABLE code)
if(NOT code EQUAL 2)
  message(FATAL_ERROR "the consumer without arguments ended with ${code}, expected 2")
endif()
file(REMOVE_RECURSE ${WORK})
