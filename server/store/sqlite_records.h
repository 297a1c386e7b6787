// Records in one SQLite file, by write-ahead log, on disk at every commit.
#pragma once

#include <memory>
#include <string>

#include "server/store/records.h"

namespace burnish {

/// Opens or makes it. Errors: BadOption when the file cannot be used, or a later version of the server made
/// it.
Result<std::unique_ptr<Records>> open_sqlite_records(const std::string& path);

}  // namespace burnish
