# check.cmake: installs a build folder below a temporary prefix, moves the prefix, then builds and runs the project in
# this folder against it.  Input: BUILD, CONFIG, COMPILER, VERSION, PYTHON, PYTHON_DIR.
set(work ${BUILD}/install-test)
set(prefix "${work}/moved here")  # has a blank, and differs from the install prefix

function(run what)
  cmake_parse_arguments(PARSE_ARGV 1 run "" "" "COMMAND")
  execute_process(COMMAND ${run_COMMAND} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${what} failed (${failed}); expected it to succeed.\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${work})
run("installing" COMMAND ${CMAKE_COMMAND} --install ${BUILD} --config "${CONFIG}" --prefix ${work}/first)
file(RENAME ${work}/first ${prefix})
run("reading the programs of the manual" COMMAND ${PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/programs.py ${work}/programs)
run("configuring the consumer" COMMAND ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${work}/build -G Ninja
    -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_PREFIX_PATH=${prefix} -D DROVER_VERSION=${VERSION}
    -D DROVER_PROGRAMS=${work}/programs)
run("building the consumer" COMMAND ${CMAKE_COMMAND} --build ${work}/build)
run("running the consumer" COMMAND ${work}/build/consumer)
if(NOT output MATCHES "^drover ${VERSION} ")
  message(FATAL_ERROR "the consumer printed '${output}'; expected 'drover ${VERSION} ...'.")
endif()
foreach(program 1 2 3)
  run("running program ${program} of the manual" COMMAND ${work}/build/program_${program})
  message(STATUS "program ${program}: ${output}")
endforeach()
run("running the installed program" COMMAND ${prefix}/bin/drover --help)
file(WRITE ${work}/mine.toml "model = {file = \"cahn-hilliard.toml\"}\ngrid = {nx = 16, ny = 16}\n")
run("naming an installed model" COMMAND ${prefix}/bin/drover explain ${work}/mine.toml)
file(GLOB module "${prefix}/${PYTHON_DIR}/drover/_drover.*.so")
if(module)  # not with sanitizers
  run("using the installed Python module" COMMAND ${CMAKE_COMMAND} -E env "PYTHONPATH=${prefix}/${PYTHON_DIR}"
      PYTHONDONTWRITEBYTECODE=1 ${PYTHON} -c "import drover; drover.Scene.from_dict({})")
endif()
file(REMOVE_RECURSE ${work})
