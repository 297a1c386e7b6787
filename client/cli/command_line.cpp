#include "client/cli/command_line.h"

#include <exception>
#include <new>
#include <ostream>

#include "client/cli/commands.h"
#include "client/cli/preferences.h"
#include "server/service/smooth_service.h"
#include "server/status_map.h"

namespace burnish::cli {
namespace {

constexpr const char* kFooter =
    "Exit codes: 0 done, 2 bad call, 3 bad mesh, 4 refused or out of time, 5 server, 6 files, 130 Ctrl-C.";

int fail(const Console& console, const Error& error) {
  print_error(console, error);
  return status_of(error.cause).exit_code;
}

Result<> run(const Command& command, const Console& console) try {
  Result<> done = command(console);
  if (done && !console.out.flush()) return Error{Cause::FileError, "cannot write to standard output"};
  return done;
} catch (const std::bad_alloc&) {
  return Error{Cause::OutOfMemory, "out of memory"};
} catch (const std::exception& failure) {
  return Error{Cause::Internal, failure.what()};
}

}  // namespace

int run_command_line(int argc, const char* const* argv, const Console& console) {
  CLI::App app("Smooths scanned triangle meshes without destroying their features.", "burnish");
  app.set_version_flag("--version", "burnish " + std::string(version()));
  app.require_subcommand(1);
  app.footer(kFooter);
  Command chosen;
  add_smooth_command(app, chosen);
  add_compare_command(app, chosen);
  add_noise_command(app, chosen);
  add_sample_command(app, chosen);
#ifdef BURNISH_RENDER
  add_render_command(app, chosen);
#endif
  add_methods_command(app, chosen);
  add_bench_command(app, chosen);
  add_completion_command(app, chosen);
  add_man_command(app, chosen);
  std::string config;
  app.add_option("--config", config,
                 "JSON file with what calls leave open; default: burnish/config.json where XDG_CONFIG_HOME "
                 "says, or in ~/.config")
      ->type_name("FILE");
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) command->fallthrough();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help, console.out, console.err);
  } catch (const CLI::Error& wrong) {
    return fail(console, {Cause::BadOption, std::string(wrong.what()) + " (see burnish --help)"});
  }
  if (const auto applied = apply_preferences(*app.get_subcommands().front(), config); !applied)
    return fail(console, applied.error());
  const Result<> done = run(chosen, console);
  return done ? 0 : fail(console, done.error());
}

}  // namespace burnish::cli
