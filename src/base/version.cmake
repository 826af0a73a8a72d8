# base/version.cmake: writes version.cpp with the current commit; runs at each build:
#   cmake -D SOURCE=<checkout> -D VERSION=<x.y.z> -D OUTPUT=<version.cpp> -P version.cmake
# The file is written only when its content changes.  A tree without .git (a tarball) has the commit "unknown".
set(git_hash unknown)
set(dirty false)
find_program(GIT git)
# A tarball unpacked inside another checkout must not take the commit of that checkout.
if(GIT AND EXISTS "${SOURCE}/.git")
  # safe.directory: allows a checkout owned by another user; fsmonitor off: does not run its hook.
  set(git "${GIT}" --no-optional-locks -c safe.directory=* -c core.fsmonitor=false -C "${SOURCE}")
  execute_process(COMMAND ${git} rev-parse --verify HEAD OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE
                  RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed)
    set(git_hash ${found})
  endif()
  # Untracked sources count: the build compiles every .cpp that it finds.
  execute_process(COMMAND ${git} status --porcelain -- CMakeLists.txt include src OUTPUT_VARIABLE changes ERROR_QUIET)
  if(changes)
    set(dirty true)
  endif()
endif()
configure_file("${CMAKE_CURRENT_LIST_DIR}/version.cpp.in" "${OUTPUT}" @ONLY)
