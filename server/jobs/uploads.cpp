#include "server/jobs/uploads.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <google/protobuf/util/time_util.h>
#include <spdlog/spdlog.h>

namespace burnish {
namespace {

/// Bytes between two points that survive a power cut: a second of a slow disk.
constexpr std::uint64_t kSyncEvery = std::uint64_t{16} << 20;

WallTime now() { return std::chrono::system_clock::now(); }

void set_time(google::protobuf::Timestamp& to, WallTime time) {
  to = google::protobuf::util::TimeUtil::MillisecondsToTimestamp(
      std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count());
}

Error no_such_upload() { return {Cause::NotFound, "there is no such upload"}; }

}  // namespace

struct Uploads::Entry {
  UploadRecord record;
  std::mutex turn;  ///< taken before mutex_: while an append writes, or another takes its place
  /// The append that is under way, and alone may change the record. Guarded by `turn` too.
  OpenAppend* holder = nullptr;
};

/// Nobody else uses the upload's part or its record, except to read it.
struct Uploads::Turn {
  EntryPtr entry;
  std::unique_lock<std::mutex> lock;
};

class Uploads::OpenAppend final : public Uploads::Append {
 public:
  /// With both locks.
  OpenAppend(Uploads& of, Caller caller, EntryPtr entry)
      : uploads_(of), caller_(std::move(caller)), entry_(std::move(entry)), synced_(upload().offset()) {
    entry_->holder = this;
  }
  ~OpenAppend() override {
    const std::lock_guard turn(entry_->turn);
    if (!holds()) return;
    if (!gone_) {
      if (auto kept = sync(); !kept) spdlog::warn("upload id={}: {}", upload().id(), kept.error().message);
    }
    const std::lock_guard lock(uploads_.mutex_);
    entry_->holder = nullptr;
  }

  Result<> write(std::string_view bytes) override {
    const std::lock_guard turn(entry_->turn);
    if (!holds()) return taken_over();
    const std::uint64_t limit = upload().bytes() > 0 ? upload().bytes() : uploads_.limit();
    if (bytes.size() > limit - upload().offset()) {
      return Error{Cause::TooLarge, "the upload has more than " + std::to_string(limit) + " bytes, " +
                                        (upload().bytes() > 0 ? "its length" : "the limit (max-bytes)")};
    }
    if (auto paid = uploads_.jobs_.charge(caller_, bytes.size(), upload().offset() + bytes.size()); !paid)
      return paid;
    if (auto written = uploads_.files_.write_part(upload().id(), upload().offset(), bytes); !written)
      return written;
    {
      const std::lock_guard lock(uploads_.mutex_);
      upload().set_offset(upload().offset() + static_cast<std::uint32_t>(bytes.size()));
    }
    return upload().offset() - synced_ < kSyncEvery ? Result<>() : sync();
  }

  Result<v1::Upload> finish(bool last) override {
    const std::lock_guard turn(entry_->turn);
    if (!holds()) return taken_over();
    if (auto kept = sync(); !kept) return std::move(kept).error();
    const bool whole = upload().bytes() > 0 && upload().offset() == upload().bytes();
    if (last && upload().bytes() > 0 && !whole) {
      return Error{Cause::BadRequest, "the upload ends after " + std::to_string(upload().offset()) + " of " +
                                          std::to_string(upload().bytes()) + " bytes"};
    }
    if (!last && !whole) return upload();
    if (upload().offset() == 0) return Error{Cause::EmptyMesh, "the upload has no bytes"};
    if (auto done = uploads_.complete(entry_); !done) {
      gone_ = done.error().cause == Cause::UploadCorrupt;
      return std::move(done).error();
    }
    gone_ = true;  // there is no part any more that could be synced
    return upload();
  }

  /// In its turn.
  Result<> sync() {
    if (synced_ == upload().offset()) return {};
    if (auto kept = uploads_.files_.sync_part(upload().id()); !kept) return kept;
    synced_ = upload().offset();
    return uploads_.save(*entry_);
  }

 private:
  v1::Upload& upload() { return entry_->record.upload; }
  bool holds() const { return entry_->holder == this; }
  static Error taken_over() {
    return {Cause::NotReady, "a later request goes on with this upload, or removed it"};
  }

  Uploads& uploads_;
  const Caller caller_;
  const EntryPtr entry_;
  std::uint64_t synced_;
  bool gone_ = false;
};

Uploads::Uploads(Records& records, FileStore& files, const Jobs& jobs, const UploadsOptions& options)
    : records_(records), files_(files), jobs_(jobs), options_(options) {}

std::uint64_t Uploads::limit() const {
  return std::min<std::uint64_t>(jobs_.limits().mesh.max_bytes, std::numeric_limits<std::uint32_t>::max());
}

Result<> Uploads::start() {
  auto records = records_.uploads();
  if (!records) return std::move(records).error();
  std::set<std::string> left = files_.parts();
  const std::lock_guard lock(mutex_);
  for (UploadRecord& record : *records) {
    v1::Upload& upload = record.upload;
    if (!upload.complete()) {
      const auto size = files_.cut_part(upload.id(), upload.offset());
      if (!size) {
        if (auto gone = records_.remove_upload(upload.id()); !gone) return gone;
        continue;
      }
      upload.set_offset(static_cast<std::uint32_t>(*size));
      left.erase(upload.id());
    }
    const std::string id = upload.id();
    const auto entry = std::make_shared<Entry>();
    entry->record = std::move(record);
    uploads_[id] = entry;
  }
  for (const std::string& part : left) files_.remove_part(part);
  return {};
}

Result<v1::Upload> Uploads::create(const Caller& caller, std::uint64_t bytes, const std::string& sha256) {
  if (bytes > limit()) {
    return Error{Cause::TooLarge, "the upload is to have " + std::to_string(bytes) + " bytes; the limit is " +
                                      std::to_string(limit()) + " (max-bytes)"};
  }
  if (auto allowed = jobs_.charge(caller, 0, bytes); !allowed) return std::move(allowed).error();
  const auto entry = std::make_shared<Entry>();
  entry->record.owner = caller.owner;
  v1::Upload& upload = entry->record.upload;
  upload.set_id(jobs_.new_kept_id());
  upload.set_bytes(static_cast<std::uint32_t>(bytes));
  set_time(*upload.mutable_create_time(), now());
  if (!sha256.empty()) {
    auto digits = parse_sha256(sha256, "sha256");
    if (!digits) return std::move(digits).error();
    upload.set_sha256(std::move(digits).value());
  }
  {
    const std::lock_guard lock(mutex_);
    const auto own = std::ranges::count_if(
        uploads_, [&](const auto& each) { return each.second->record.owner == caller.owner; });
    if (static_cast<std::uint64_t>(own) >= options_.most_per_owner)
      return Error{Cause::QuotaExceeded, "there are " + std::to_string(own) + " uploads already"};
  }
  const auto held = files_.hold();
  const auto known = fill_if_known(*entry);
  if (!known) return known.error();
  if (!*known) {
    if (auto made = files_.create_part(upload.id()); !made) return std::move(made).error();
  }
  if (auto kept = save(*entry); !kept) return std::move(kept).error();
  const std::lock_guard lock(mutex_);
  uploads_[upload.id()] = entry;
  return upload;
}

/// An upload of a mesh that its owner has is complete before it begins.
Result<bool> Uploads::fill_if_known(Entry& entry) {
  v1::Upload& upload = entry.record.upload;
  if (upload.sha256().empty()) return false;
  auto known = records_.has_mesh(entry.record.owner, upload.sha256());
  if (!known || !*known) return known;
  const auto content = files_.map(upload.sha256());
  if (!content) return false;
  const auto size = static_cast<std::uint32_t>(content->bytes.size());
  if (upload.bytes() != 0 && upload.bytes() != size) {
    return Error{Cause::UploadCorrupt, "the mesh of this SHA-256 has " + std::to_string(size) +
                                           " bytes, not " + std::to_string(upload.bytes())};
  }
  upload.set_bytes(size);
  upload.set_offset(size);
  upload.set_complete(true);
  auto kept = records_.put(MeshRecord{entry.record.owner, upload.sha256(), now() + options_.keep});
  return kept ? Result<bool>(true) : Result<bool>(std::move(kept).error());
}

Result<Uploads::EntryPtr> Uploads::find(const Caller& caller, const std::string& id) {
  const auto found = uploads_.find(id);
  if (found == uploads_.end() || found->second->record.owner != caller.owner) return no_such_upload();
  return found->second;
}

Result<v1::Upload> Uploads::get(const Caller& caller, const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto entry = find(caller, id);
  if (!entry) return entry.error();
  return (*entry)->record.upload;
}

Result<Uploads::Turn> Uploads::turn_at(const Caller& caller, const std::string& id) {
  Turn turn;
  {
    const std::lock_guard lock(mutex_);
    auto found = find(caller, id);
    if (!found) return std::move(found).error();
    turn.entry = std::move(found).value();
  }
  turn.lock = std::unique_lock(turn.entry->turn);
  const std::lock_guard lock(mutex_);
  if (auto still = find(caller, id); !still) return std::move(still).error();
  return turn;
}

Result<> Uploads::remove(const Caller& caller, const std::string& id) {
  const auto turn = turn_at(caller, id);
  if (!turn) return turn.error();
  {
    const std::lock_guard lock(mutex_);
    if (uploads_.erase(id) == 0) return no_such_upload();  // swept meanwhile
    turn->entry->holder = nullptr;
  }
  forget(turn->entry);
  return {};
}

/// What holds the upload may be the connection of a client that lost its network: the later request goes on.
Result<std::unique_ptr<Uploads::Append>> Uploads::append(const Caller& caller, const std::string& id,
                                                         std::uint64_t offset) {
  const auto turn = turn_at(caller, id);
  if (!turn) return turn.error();
  Entry& entry = *turn->entry;
  const v1::Upload& upload = entry.record.upload;
  if (upload.complete()) return Error{Cause::UploadOffsetMismatch, "the upload is complete"};
  if (upload.offset() != offset) {
    return Error{Cause::UploadOffsetMismatch, "the upload has " + std::to_string(upload.offset()) +
                                                  " bytes; the next ones do not begin at " +
                                                  std::to_string(offset)};
  }
  if (entry.holder) {
    if (auto kept = entry.holder->sync(); !kept) return std::move(kept).error();
  }
  const std::lock_guard lock(mutex_);
  if (!uploads_.contains(id)) return no_such_upload();  // swept meanwhile
  return std::unique_ptr<Append>(std::make_unique<OpenAppend>(*this, caller, turn->entry));
}

Result<> Uploads::save(Entry& entry) {
  UploadRecord record;
  {
    const std::lock_guard lock(mutex_);
    entry.record.expires = now() + options_.keep;
    set_time(*entry.record.upload.mutable_expire_time(), entry.record.expires);
    record = entry.record;
  }
  return records_.put(record);
}

void Uploads::forget(const EntryPtr& entry) {
  const v1::Upload& upload = entry->record.upload;
  if (!upload.complete()) files_.remove_part(upload.id());
  if (auto gone = records_.remove_upload(upload.id()); !gone)
    spdlog::warn("upload id={}: {}", upload.id(), gone.error().message);
}

/// All bytes are there.
Result<> Uploads::complete(const EntryPtr& entry) {
  const auto held = files_.hold();
  const std::string id = entry->record.upload.id();
  auto sha256 = files_.finish_part(id, entry->record.upload.sha256());
  if (!sha256) {
    if (sha256.error().cause == Cause::UploadCorrupt) {
      {
        const std::lock_guard lock(mutex_);
        uploads_.erase(id);
      }
      forget(entry);
    }
    return std::move(sha256).error();
  }
  if (auto kept = records_.put(MeshRecord{entry->record.owner, *sha256, now() + options_.keep}); !kept)
    return kept;
  {
    const std::lock_guard lock(mutex_);
    v1::Upload& upload = entry->record.upload;
    upload.set_sha256(*sha256);
    upload.set_bytes(upload.offset());
    upload.set_complete(true);
  }
  return save(*entry);
}

void Uploads::sweep(WallTime at) {
  std::vector<EntryPtr> old;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(uploads_, [&](const auto& each) {
      const bool over = each.second->holder == nullptr && each.second->record.expires <= at;
      if (over) old.push_back(each.second);
      return over;
    });
  }
  for (const EntryPtr& entry : old) forget(entry);
}

}  // namespace burnish
