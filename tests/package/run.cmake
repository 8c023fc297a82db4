# Installs a build of softcd into a fresh folder and builds and runs the consumer project against it.
#
#   cmake -D BUILD_DIR=... -D WORK_DIR=... -D GENERATOR=... -D CXX=... -D CTEST=... -D ARGUMENTS=... -P run.cmake

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${WORK_DIR}")
run("${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${WORK_DIR}/install")
run("${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK_DIR}/build" -G "${GENERATOR}"
    "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_PREFIX_PATH=${WORK_DIR}/install" -DCMAKE_BUILD_TYPE=Release ${ARGUMENTS})
run("${CMAKE_COMMAND}" --build "${WORK_DIR}/build")
run("${CTEST}" --test-dir "${WORK_DIR}/build" --output-on-failure --no-tests=error)
