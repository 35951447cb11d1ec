file(READ "${INPUT}" text)
if(text MATCHES "\\)embedded\"")
  message(FATAL_ERROR "${INPUT} holds the raw-string delimiter )embedded\"")
endif()
file(WRITE "${OUTPUT}" "namespace reamsim::embedded {
extern const char* const ${VARIABLE};
const char* const ${VARIABLE} = R\"embedded(${text})embedded\";
}  // namespace reamsim::embedded
")
