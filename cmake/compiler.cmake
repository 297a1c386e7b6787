# Flags that every target of ours gets: warnings are errors, and arithmetic is the same on every x86-64 processor.
add_library(burnish_flags INTERFACE)
target_compile_options(burnish_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wfloat-conversion -Werror
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> # GCC 12 sees overlaps in std::string's operator+ that are not there (its bug 105651)
  # a*b+c must round twice everywhere, or meshes would differ between machines.
  -ffp-contract=off
  # GCC 12's SLP vectoriser drops the rounding of double to float to double, from -O2 on: wrong, and it varies.
  -fno-tree-slp-vectorize)
if(BURNISH_SANITIZE)
  target_compile_options(burnish_flags INTERFACE
    -fsanitize=${BURNISH_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(burnish_flags INTERFACE -fsanitize=${BURNISH_SANITIZE})
  if(BURNISH_SANITIZE MATCHES thread)
    # Under this macro protobuf's map fields grow by two members, which Debian's libprotobuf does not know about;
    # the standard library must still hear of the sanitizer.
    target_compile_options(burnish_flags INTERFACE -U__SANITIZE_THREAD__ -D_GLIBCXX_TSAN=1)
  endif()
endif()
