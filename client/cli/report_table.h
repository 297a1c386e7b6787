// Reports as a person reads them.
#pragma once

#include <iosfwd>

#include "burnish/v1/smoothing.pb.h"

namespace burnish::cli {

void print_report(std::ostream& out, const v1::SmoothReport& report);
void print_comparison(std::ostream& out, const v1::CompareResponse& comparison);

}  // namespace burnish::cli
