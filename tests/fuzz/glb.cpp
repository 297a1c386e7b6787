#include "tests/support/glb.h"
#include "tests/fuzz/round_trip.h"

/// Either a whole file, or the JSON, a zero and the buffer: so that what changes the length of one does not
/// have to change three lengths with it.
extern "C" int LLVMFuzzerTestOneInput(const char* data, std::size_t size) {
  const std::string_view input(data, size);
  if (input.starts_with("glTF")) {
    burnish::fuzz::round_trip(input, burnish::Format::Glb);
    return 0;
  }
  const std::size_t zero = std::min(input.find('\0'), size);
  const std::string_view bin = input.substr(std::min(zero + 1, size));
  burnish::fuzz::round_trip(burnish::testing::to_glb(input.substr(0, zero), bin), burnish::Format::Glb);
  return 0;
}
