// Under the leak sanitizer: the readers of ITK's formats forget memory when they give up on a damaged file.
extern "C" const char* __lsan_default_suppressions();  // NOLINT: the sanitizer's own name

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libITKNrrdIO\n"
         "leak:libITKMetaIO\n"
         "leak:libITKniftiio\n";
}
