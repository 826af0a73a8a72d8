# base/version.cmake: writes version.cpp with the commit that is built; run at each build:
#   cmake -D SOURCE=<checkout> -D VERSION=<x.y.z> -D OUTPUT=<version.cpp> -P version.cmake
# The file is touched only when its text changes.  A tree without .git (a tarball) has no commit: "unknown".
set(git_hash unknown)
set(dirty false)
find_program(GIT git)
# A tarball unpacked inside another checkout has a parent with .git, which is not ours.
if(GIT AND EXISTS "${SOURCE}/.git")
  # safe.directory: a checkout that belongs to another user is read all the same; fsmonitor off: its hook is not run.
  set(git "${GIT}" --no-optional-locks -c safe.directory=* -c core.fsmonitor=false -C "${SOURCE}")
  execute_process(COMMAND ${git} rev-parse --verify HEAD OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE
                  RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed)
    set(git_hash ${found})
  endif()
  # Untracked sources count too: the build takes every .cpp it finds.
  execute_process(COMMAND ${git} status --porcelain -- CMakeLists.txt include src OUTPUT_VARIABLE changes ERROR_QUIET)
  if(changes)
    set(dirty true)
  endif()
endif()
configure_file("${CMAKE_CURRENT_LIST_DIR}/version.cpp.in" "${OUTPUT}" @ONLY)
