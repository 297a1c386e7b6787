#include "server/sandbox/helper.h"

#include <malloc.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <list>
#include <mutex>
#include <optional>
#include <thread>

#include "server/sandbox/channel.h"
#include "server/sandbox/filter.h"
#include "server/sandbox/messages.h"
#include "server/sandbox/shared_buffer.h"

namespace burnish {
namespace {

constexpr std::chrono::milliseconds kIdle{1000};
constexpr int kFirstForeignFile = 7;

/// A part of a file, mapped.
class Mapping {
 public:
  Mapping(int file, std::uint64_t offset, std::uint64_t bytes) {
    if (bytes == 0) return;
    const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    const std::uint64_t skipped = offset % page;
    size_ = bytes + skipped;
    address_ = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, file, static_cast<off_t>(offset - skipped));
    if (address_ == MAP_FAILED) throw std::bad_alloc();
    bytes_ = {static_cast<const char*>(address_) + skipped, bytes};
  }
  ~Mapping() {
    if (size_ > 0) ::munmap(address_, size_);
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  std::string_view bytes() const { return bytes_; }

 private:
  void* address_ = nullptr;
  std::uint64_t size_ = 0;
  std::string_view bytes_;
};

class Helper {
 public:
  explicit Helper(SmoothFunction smooth) : smooth_(std::move(smooth)) {}

  int run() {
    sandbox::Setup setup;
    if (jobs_.receive(setup) != Channel::Got::Message) return 0;
    service_ = SmoothService(limits_of(setup));
    if (!smooth_)
      smooth_ = [this](const SmoothJob& job, const RunControl& control) {
        return service_.smooth(job, control);
      };
    warm_up();
    sandbox::Reply ready;
    if (auto given_up = give_up_rights(setup.max_memory()); !given_up)
      set_failure(given_up.error(), *ready.mutable_failure());
    if (!jobs_.send(ready) || ready.has_failure()) return 1;
    serve();
    return 0;
  }

 private:
  /// What libraries open when they are first used is opened while it can be.
  void warm_up() const {
    const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    SmoothJob job{.mesh = mesh};
    job.options.mutable_output()->set_format(v1::MESH_FORMAT_DRACO);
    const auto smoothed = service_.smooth(job, {.threads = 0});
    if (smoothed) static_cast<void>(service_.smooth({.mesh = smoothed->mesh}, {.threads = 0}));
  }

  void serve() {
    std::thread([this] { hear_cancels(); }).detach();  // ends with the process
    bool rested = true;
    for (;;) {
      sandbox::Request request;
      std::vector<File> files;
      const auto timeout = rested ? std::optional<std::chrono::milliseconds>() : kIdle;
      const auto got = jobs_.receive(request, timeout, &files);
      if (got == Channel::Got::Message) {
        work(request, files, begin(request.job()));
        rested = false;
      } else if (got == Channel::Got::Nothing) {
        ::malloc_trim(0);
        rested = true;
      } else {
        return;
      }
    }
  }

  /// A cancel may overtake the job that it means.
  void hear_cancels() {
    sandbox::Cancel cancel;
    while (cancels_.receive(cancel) == Channel::Got::Message) {
      const std::lock_guard lock(mutex_);
      cancelled_ = cancel.job();
      if (cancelled_ == job_) stop_.request_stop();
    }
    ::_exit(0);  // burnishd is gone; the other thread may be in the middle of anything
  }

  std::stop_token begin(std::uint64_t job) {
    const std::lock_guard lock(mutex_);
    job_ = job;
    stop_ = {};
    if (cancelled_ == job) stop_.request_stop();
    return stop_.get_token();
  }

  void work(const sandbox::Request& request, const std::vector<File>& files, const std::stop_token& stop) {
    RunControl control{.stop = stop, .threads = request.threads()};
    if (request.deadline_us() > 0)
      control.deadline = RunControl::Clock::now() + std::chrono::microseconds(request.deadline_us());
    sandbox::Reply reply;
    try {
      std::size_t next = 0;
      std::list<Mapping> mappings;
      const auto bytes_of = [&](const sandbox::Place& place) {
        if (!place.in_file()) return input_.read(place.offset(), place.bytes());
        if (next >= files.size()) throw std::runtime_error("a mesh did not come");
        return mappings.emplace_back(files[next++].get(), place.offset(), place.bytes()).bytes();
      };
      const std::string_view mesh = bytes_of(request.mesh()), reference = bytes_of(request.reference());
      if (request.compare()) {
        compare(request, mesh, reference, control, reply);
      } else {
        smooth(request, mesh, reference, control, reply);
      }
    } catch (const std::bad_alloc&) {
      set_failure({Cause::OutOfMemory, "not enough memory for this mesh"}, *reply.mutable_failure());
    } catch (const std::exception& failure) {
      set_failure({Cause::Internal, failure.what()}, *reply.mutable_failure());
    }
    reply.set_ended(true);
    jobs_.send(reply);
  }

  void smooth(const sandbox::Request& request, std::string_view mesh, std::string_view reference,
              const RunControl& control, sandbox::Reply& reply) {
    SmoothJob job{.mesh = mesh,
                  .format = from_proto(request.format()),
                  .reference = reference,
                  .reference_format = from_proto(request.reference_format()),
                  .options = request.options(),
                  .request_id = request.request_id(),
                  .queue_ms = request.queue_ms()};
    if (request.progress()) {
      job.progress = [this](v1::SmoothStage stage, double fraction) {
        sandbox::Reply progress;
        progress.mutable_progress()->set_stage(stage);
        progress.mutable_progress()->set_fraction(fraction);
        jobs_.send(progress);
      };
    }
    auto result = smooth_(job, control);
    if (!result) return set_failure(result.error(), *reply.mutable_failure());
    if (auto written = output_.write(0, result->mesh, control); !written)
      return set_failure(written.error(), *reply.mutable_failure());
    reply.set_bytes(result->mesh.size());
    reply.set_format(to_proto(result->format));
    *reply.mutable_report() = std::move(result->report);
  }

  void compare(const sandbox::Request& request, std::string_view mesh, std::string_view reference,
               const RunControl& control, sandbox::Reply& reply) const {
    auto compared = service_.compare({.reference = reference,
                                      .reference_format = from_proto(request.reference_format()),
                                      .mesh = mesh,
                                      .format = from_proto(request.format()),
                                      .request_id = request.request_id(),
                                      .queue_ms = request.queue_ms()},
                                     control);
    if (!compared) return set_failure(compared.error(), *reply.mutable_failure());
    *reply.mutable_comparison() = std::move(compared).value();
  }

  Channel jobs_{File::adopt(kHelperJobs)}, cancels_{File::adopt(kHelperCancels)};
  SharedBuffer input_{File::adopt(kHelperInput), false}, output_{File::adopt(kHelperOutput), true};
  SmoothService service_;
  SmoothFunction smooth_;
  std::mutex mutex_;  ///< guards what follows
  std::uint64_t job_ = 0, cancelled_ = 0;
  std::stop_source stop_;
};

}  // namespace

int run_helper(SmoothFunction smooth) {
  std::signal(SIGXFSZ, SIG_IGN);  // a result beyond all bounds is an error, not an end
  ::prctl(PR_SET_NAME, "burnish-helper");
  ::close_range(kFirstForeignFile, ~0U, 0);
  return Helper(std::move(smooth)).run();
}

}  // namespace burnish
