cmake_minimum_required(VERSION 3.25)
# Writes a header with one number that changes whenever the code that makes frames does: recorded sequences are used
# again only by a program that would make the same ones.
#   cmake -D SOURCES="a|b|..." -D HEADER=file.h -P frames_fingerprint.cmake
string(REPLACE "|" ";" SOURCES "${SOURCES}")
list(SORT SOURCES)
set(all "")
foreach(source ${SOURCES})
  file(SHA256 ${source} digest)
  string(APPEND all ${digest})
endforeach()
string(SHA256 fingerprint "${all}")
string(SUBSTRING ${fingerprint} 0 16 fingerprint)
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#define GAITCAM_FRAMES_FINGERPRINT \"@fingerprint@\"\n" @ONLY)
