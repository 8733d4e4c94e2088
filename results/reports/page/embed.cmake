cmake_minimum_required(VERSION 3.25)
# Writes a source that defines PageFile (results/reports/page_file.h) with the text of each file.
#   cmake -D FILES="a.css|b.js|..." -D SOURCE=page_files.cpp -P embed.cmake
string(REPLACE "|" ";" FILES "${FILES}")
set(text "#include \"results/reports/page_file.h\"\n\n#include \"algorithms/core/errors.h\"\n\n")
string(APPEND text "namespace gaitcam::internal {\n\nstd::string_view PageFile(std::string_view name) {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" content)
  string(APPEND text "  if (name == \"${name}\") return R\"embedded(${content})embedded\";\n")
endforeach()
string(APPEND text "  GAITCAM_ASSERT(false);\n  return {};\n}\n\n}  // namespace gaitcam::internal\n")
file(WRITE "${SOURCE}" "${text}")
