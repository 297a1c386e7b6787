#include <cstdlib>

#include "tests/fuzz/house.h"

/// The input is the body of a form with the boundary "x"; the head around it is as it should be.
extern "C" int LLVMFuzzerTestOneInput(const char* data, std::size_t size) {
  std::string request =
      "POST /v1/smooth HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
      "Content-Type: multipart/form-data; boundary=x\r\nContent-Length: " +
      std::to_string(size) + "\r\n\r\n";
  request.append(data, size);
  if (burnish::fuzz::house().answer(request).empty()) std::abort();
  return 0;
}
