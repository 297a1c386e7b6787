#include "tests/fuzz/round_trip.h"

extern "C" int LLVMFuzzerTestOneInput(const char* data, std::size_t size) {
  burnish::fuzz::round_trip({data, size}, burnish::Format::Stl);
  return 0;
}
