#include "server/store/file_store.h"

#include <openssl/evp.h>
#include <sys/file.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <optional>
#include <system_error>

#include "server/mapped_files.h"
#include "server/store/file.h"

namespace burnish {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigits = 64;
constexpr std::size_t kHashedAtOnce = std::size_t{1} << 20;
constexpr const char *kFiles = "/files", *kParts = "/parts", *kTemporary = "/temporary";

Error no_such_file() { return {Cause::NotFound, "the server has no such mesh"}; }
Error no_such_upload() { return {Cause::NotFound, "there is no such upload"}; }

/// A name is on disk only when its folder is.
Result<> sync_folder(const std::string& folder) {
  const File file(folder, O_RDONLY | O_DIRECTORY);
  return file.is_open() ? file.sync() : Result<>(File::cannot_store(errno));
}

/// A mapping, its file, and the word that the file is mapped.
struct MappedBytes {
  MappedBytes(File from, const char* address, std::uint64_t length)
      : file(std::move(from)), bytes(address, length) {
    told.emplace(bytes, file.get());
  }
  ~MappedBytes() {
    told.reset();
    ::munmap(const_cast<char*>(bytes.data()), bytes.size());
  }
  MappedBytes(const MappedBytes&) = delete;
  MappedBytes& operator=(const MappedBytes&) = delete;

  const File file;
  const std::string_view bytes;
  std::optional<MappedFile> told;
};

Result<StoredBytes> map_file(File file) {
  const std::uint64_t size = file.size();
  if (size == 0) return StoredBytes{};
  void* const address = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (address == MAP_FAILED) return Error{Cause::OutOfMemory, "the server cannot map a mesh"};
  const auto mapped =
      std::make_shared<const MappedBytes>(std::move(file), static_cast<const char*>(address), size);
  return StoredBytes{.bytes = mapped->bytes, .owner = mapped};
}

std::uint64_t size_of(const std::string& path) {
  std::error_code failure;
  const auto size = fs::file_size(path, failure);
  return failure ? 0 : size;
}

}  // namespace

std::string sha256_of(std::string_view bytes) {
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), kHashedAtOnce)))
    EVP_DigestUpdate(context.get(), bytes.data(), std::min(bytes.size(), kHashedAtOnce));
  EVP_DigestFinal_ex(context.get(), digest.data(), &size);
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < size; ++i) {
    text += kHex[digest.at(i) >> 4];
    text += kHex[digest.at(i) & 15];
  }
  return text;
}

Result<std::string> parse_sha256(std::string_view text, const std::string& field) {
  std::string digits(text);
  std::ranges::transform(digits, digits.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool fine = digits.size() == kDigits &&
                    std::ranges::all_of(digits, [](unsigned char c) { return std::isxdigit(c) != 0; });
  if (!fine) {
    return Error{Cause::BadOption, field + " is not a SHA-256: it has 64 hexadecimal digits", field};
  }
  return digits;
}

Result<std::unique_ptr<FileStore>> FileStore::open(const FileStoreOptions& options) {
  auto store = std::unique_ptr<FileStore>(new FileStore(options));
  if (auto ready = store->prepare(); !ready) return std::move(ready).error();
  return store;
}

FileStore::~FileStore() {
  if (lock_ >= 0) ::close(lock_);
}

Result<> FileStore::prepare() {
  const auto unusable = [this](const std::string& why) {
    return Error{Cause::BadOption, "cannot use the store '" + options_.folder + "' (store): " + why};
  };
  std::error_code failure;
  for (const char* part : {"", kFiles, kParts, kTemporary}) {
    fs::create_directories(options_.folder + part, failure);
    if (failure) return unusable(failure.message());
  }
  fs::permissions(options_.folder, fs::perms::owner_all, failure);  // meshes are their owners' alone
  File lock(options_.folder + "/lock", O_RDWR | O_CREAT);
  if (!lock.is_open()) return unusable(std::strerror(errno));
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) return unusable("another server uses it");
  lock_ = lock.release();
  for (const auto& each : fs::directory_iterator(options_.folder + kTemporary, failure))
    fs::remove(each.path(), failure);
  for (const char* part : {kFiles, kParts}) {
    for (const auto& each : fs::recursive_directory_iterator(options_.folder + part, failure))
      if (each.is_regular_file(failure)) bytes_ += size_of(each.path());
  }
  return {};
}

/// Room for so many bytes more.
Result<> FileStore::take(std::uint64_t bytes) {
  std::uint64_t now = bytes_;
  do {
    if (bytes > options_.max_bytes || now > options_.max_bytes - bytes) {
      return Error{Cause::StorageFull, "the server's store holds " + std::to_string(now) + " of " +
                                           std::to_string(options_.max_bytes) + " bytes (max-store-bytes)"};
    }
  } while (!bytes_.compare_exchange_weak(now, now + bytes));
  return {};
}

std::string FileStore::path_of(const std::string& sha256) const {
  return options_.folder + kFiles + "/" + sha256.substr(0, 2) + "/" + sha256;
}

std::string FileStore::part_path(const std::string& id) const { return options_.folder + kParts + "/" + id; }

bool FileStore::has(const std::string& sha256) const { return File(path_of(sha256), O_RDONLY).is_open(); }

Result<StoredBytes> FileStore::map(const std::string& sha256) const {
  File file(path_of(sha256), O_RDONLY);
  if (!file.is_open()) return no_such_file();
  return map_file(std::move(file));
}

Result<> FileStore::put(std::string_view bytes, const std::string& sha256) {
  if (has(sha256)) return {};
  if (auto room = take(bytes.size()); !room) return room;
  const std::string path = options_.folder + kTemporary + "/" + std::to_string(temporary_++);
  Result<> kept;
  {
    const File file(path, O_WRONLY | O_CREAT | O_EXCL);
    kept = file.is_open() ? file.write(0, bytes) : Result<>(File::cannot_store(errno));
    if (kept) kept = file.sync();
  }
  if (kept) kept = adopt(path, sha256, bytes.size());
  if (!kept) {
    ::unlink(path.c_str());
    bytes_ -= bytes.size();
  }
  return kept;
}

/// A file that is whole and on disk gets its name; `size` of its bytes are counted already.
Result<> FileStore::adopt(const std::string& path, const std::string& sha256, std::uint64_t size) {
  const std::string name = path_of(sha256), folder = fs::path(name).parent_path();
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (::link(path.c_str(), name.c_str()) == 0) {
    auto synced = sync_folder(folder);
    if (synced) synced = sync_folder(options_.folder + kFiles);
    ::unlink(synced ? path.c_str() : name.c_str());
    return synced;
  }
  if (errno != EEXIST) return File::cannot_store(errno);
  ::unlink(path.c_str());  // somebody else has put the same bytes
  bytes_ -= size;
  return {};
}

void FileStore::remove_file(const std::string& path) {
  const std::uint64_t size = size_of(path);
  if (::unlink(path.c_str()) == 0) bytes_ -= size;
}

Result<> FileStore::sweep(const std::function<Result<std::set<std::string>>()>& in_use) {
  const std::unique_lock lock(sweeping_, std::try_to_lock);
  if (!lock) return {};
  const auto needed = in_use();
  if (!needed) return needed.error();
  std::error_code failure;
  for (const auto& each : fs::recursive_directory_iterator(options_.folder + kFiles, failure)) {
    if (each.is_regular_file(failure) && !needed->contains(each.path().filename())) remove_file(each.path());
  }
  return {};
}

Result<> FileStore::create_part(const std::string& id) {
  const File file(part_path(id), O_WRONLY | O_CREAT | O_EXCL);
  if (!file.is_open()) return File::cannot_store(errno);
  return sync_folder(options_.folder + kParts);
}

Result<> FileStore::write_part(const std::string& id, std::uint64_t offset, std::string_view bytes) {
  const File file(part_path(id), O_WRONLY);
  if (!file.is_open()) return no_such_upload();
  const std::uint64_t before = file.size(), after = std::max(before, offset + bytes.size());
  if (auto room = take(after - before); !room) return room;
  auto written = file.write(offset, bytes);
  bytes_ -= after - std::max(before, file.size());  // less when the disk is full
  return written;
}

Result<> FileStore::sync_part(const std::string& id) {
  const File file(part_path(id), O_WRONLY);
  return file.is_open() ? file.sync() : Result<>(no_such_upload());
}

Result<std::uint64_t> FileStore::cut_part(const std::string& id, std::uint64_t size) {
  const File file(part_path(id), O_WRONLY);
  if (!file.is_open()) return no_such_upload();
  const std::uint64_t before = file.size(), after = std::min(before, size);
  if (::ftruncate(file.get(), static_cast<off_t>(after)) != 0) return File::cannot_store(errno);
  bytes_ -= before - after;
  return after;
}

Result<std::string> FileStore::finish_part(const std::string& id, const std::string& expected) {
  std::string sha256;
  std::uint64_t size = 0;
  {
    File file(part_path(id), O_RDWR);
    if (!file.is_open()) return no_such_upload();
    if (auto synced = file.sync(); !synced) return synced.error();
    const auto content = map_file(std::move(file));
    if (!content) return content.error();
    sha256 = sha256_of(content->bytes);
    size = content->bytes.size();
  }
  if (!expected.empty() && sha256 != expected) {
    remove_part(id);
    return Error{Cause::UploadCorrupt, "the upload's SHA-256 is " + sha256 + ", not " + expected +
                                           " as announced; it is forgotten"};
  }
  if (auto kept = adopt(part_path(id), sha256, size); !kept) return kept.error();
  return sha256;
}

void FileStore::remove_part(const std::string& id) { remove_file(part_path(id)); }

std::set<std::string> FileStore::parts() const {
  std::set<std::string> ids;
  std::error_code failure;
  for (const auto& each : fs::directory_iterator(options_.folder + kParts, failure))
    ids.insert(each.path().filename());
  return ids;
}

}  // namespace burnish
