// How this process asks the system for memory.
#pragma once

namespace burnish::cli {

/// For a process that works on one large mesh and ends: what a stage gives back serves the next instead of
/// going to the system, and comes in large pages. A quarter of the time of a mesh with a million triangles
/// goes into clearing and mapping small pages otherwise. To be called before anything large is allocated.
void keep_memory();

}  // namespace burnish::cli
