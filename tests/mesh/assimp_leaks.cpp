// The address sanitizer asks this at the end: assimp forgets some memory when it gives a damaged file up. That is not
// ours to free, and leaks of our own still count.
extern "C" const char* __lsan_default_suppressions();  // NOLINT: the name is the sanitizer's

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libassimp\n";
}
