// For builds with the leak sanitizer, which asks the program itself: libhdf5 loses some bytes when
// it refuses some files.

extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
