// What a helper process gives up before it sees foreign bytes.
#pragma once

#include <cstdint>

#include "core/run/error.h"

namespace burnish {

/// All of this process's threads, and those to come, may from now on only compute: use memory, threads,
/// clocks and the files that are open. No file, socket or program can be opened, no code mapped, no other
/// process touched; what is not allowed fails with EPERM. `max_memory`: bytes of its own that it may have; 0:
/// any. Cannot be undone. Errors: Internal, when the kernel cannot do it.
Result<> give_up_rights(std::uint64_t max_memory);

}  // namespace burnish
