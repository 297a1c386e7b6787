# Flags that every target of ours gets: warnings are errors, and arithmetic is the same on every x86-64 processor.
add_library(burnish_flags INTERFACE)
target_compile_options(burnish_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wfloat-conversion -Werror
  -ffp-contract=off) # a*b+c must round twice everywhere, or meshes would differ between machines
if(BURNISH_SANITIZE)
  target_compile_options(burnish_flags INTERFACE
    -fsanitize=${BURNISH_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(burnish_flags INTERFACE -fsanitize=${BURNISH_SANITIZE})
endif()
