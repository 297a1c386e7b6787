// Reports as a person reads them.
#pragma once

#include <iosfwd>

#include "burnish/v1/smoothing.pb.h"

namespace burnish::cli {

void print_report(std::ostream& out, const v1::SmoothReport& report);
void print_errors(std::ostream& out, const v1::MeshErrors& errors);

}  // namespace burnish::cli
