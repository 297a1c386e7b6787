#include "tests/fuzz/house.h"

extern "C" int LLVMFuzzerTestOneInput(const char* data, std::size_t size) {
  burnish::fuzz::house().answer({data, size});
  return 0;
}
