# Installs the licence texts of the package that the file `LIBRARY` is from to `FOLDER`. Debian's texts leave out what its
# base-files has, which then is installed with them.

file(REAL_PATH "${LIBRARY}" file)
execute_process(COMMAND dpkg-query --search "${file}" OUTPUT_VARIABLE owner ERROR_QUIET)
string(REGEX MATCH "^[^:, ]+" package "${owner}")
set(text "/usr/share/doc/${package}/copyright")
if(NOT package OR NOT EXISTS "${text}")
  message(WARNING "No package says under which licence ${file} is. The wheel has it without its licence: add the text "
                  "before you pass the wheel on.")
  return()
endif()
file(INSTALL "${text}" DESTINATION "${FOLDER}/${package}")
file(READ "${text}" content)
string(REGEX MATCHALL "/usr/share/common-licenses/[A-Za-z0-9.-]*[A-Za-z0-9]" common "${content}")
list(REMOVE_DUPLICATES common)
foreach(licence IN LISTS common)
  file(INSTALL "${licence}" DESTINATION "${FOLDER}/${package}" FOLLOW_SYMLINK_CHAIN)
endforeach()
