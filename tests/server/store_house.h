// A store on a folder, as a server opens it.
#pragma once

#include <memory>
#include <string>

#include "server/store/file_store.h"
#include "server/store/sqlite_records.h"
#include "tests/client/temporary_folder.h"

namespace burnish::testing {

/// The store of one server's life; another one on the same folder sees what is left.
struct Store {
  explicit Store(const std::string& folder, std::uint64_t max_bytes = FileStoreOptions().max_bytes)
      : files(FileStore::open({.folder = folder, .max_bytes = max_bytes}).value()),
        records(open_sqlite_records(folder + "/records.sqlite").value()) {}

  std::unique_ptr<FileStore> files;
  std::unique_ptr<Records> records;
};

}  // namespace burnish::testing
