// The commands. Each adds itself to the application and, when it is the one called, sets `chosen` to its
// work.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "client/cli/console.h"
#include "core/run/error.h"

namespace burnish::cli {

using Command = std::function<Result<>(const Console&)>;

void add_smooth_command(CLI::App& app, Command& chosen);
void add_compare_command(CLI::App& app, Command& chosen);
void add_noise_command(CLI::App& app, Command& chosen);
void add_sample_command(CLI::App& app, Command& chosen);
void add_methods_command(CLI::App& app, Command& chosen);
void add_bench_command(CLI::App& app, Command& chosen);
void add_render_command(CLI::App& app, Command& chosen);
/// Both read the other commands of `app`, which must outlive the work.
void add_completion_command(CLI::App& app, Command& chosen);
void add_man_command(CLI::App& app, Command& chosen);

}  // namespace burnish::cli
