// One helper process, seen from burnishd.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <string>

#include "server/sandbox/channel.h"
#include "server/sandbox/shared_buffer.h"

namespace burnish {

/// Killed when this goes. One thread at a time.
class HelperProcess {
 public:
  /// Starts `program` with kHelperArgument and nothing of this process: no open file, next to no environment.
  /// Errors: Internal.
  static Result<std::unique_ptr<HelperProcess>> start(const std::string& program);
  ~HelperProcess();
  HelperProcess(const HelperProcess&) = delete;
  HelperProcess& operator=(const HelperProcess&) = delete;

  Channel& jobs() { return jobs_; }
  Channel& cancels() { return cancels_; }
  pid_t id() const { return id_; }
  std::uint64_t resident_bytes() const;

  SharedBuffer& input() { return input_; }
  SharedBuffer& output() { return output_; }

  /// Ends it if it has not ended. What became of it: "signal 11 (Segmentation fault)", "exit 1".
  std::string end();

 private:
  HelperProcess(File jobs, File cancels, File input, File output)
      : jobs_(std::move(jobs)),
        cancels_(std::move(cancels)),
        input_(std::move(input), true),
        output_(std::move(output), false) {}

  Channel jobs_, cancels_;
  SharedBuffer input_, output_;
  pid_t id_ = -1;
  std::string ending_;
};

}  // namespace burnish
