// The parts of the HTTP transport that need no socket.
#include <gtest/gtest.h>
#include <zlib.h>

#include <condition_variable>
#include <future>
#include <mutex>

#include "server/http/body_reader.h"
#include "server/http/connection_threads.h"
#include "server/http/gzip.h"
#include "server/http/header_value.h"
#include "server/http/request_reader.h"

namespace burnish {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const auto never = [] { return false; };

std::string mixed_text(std::size_t size) {
  std::string text;
  for (std::size_t i = 0; text.size() < size; ++i)
    text += "v " + std::to_string(i * 7919 % 100'003) + " 0 1\n";
  return text.substr(0, size);
}

Result<std::string> inflated(std::string_view bytes, std::size_t at_once) {
  Inflater inflater;
  std::string plain;
  const ByteSink sink = [&](std::string_view piece) {
    plain.append(piece);
    return Result<>();
  };
  for (; !bytes.empty(); bytes.remove_prefix(std::min(at_once, bytes.size()))) {
    if (auto fed = inflater.feed(bytes.substr(0, at_once), sink); !fed) return fed.error();
  }
  if (auto whole = inflater.finish(); !whole) return whole.error();
  return plain;
}

TEST(HeaderValue, SplitsOutsideQuotesOnly) {
  EXPECT_EQ(split_value(R"( a , "b,c" ,"d\",e",)", ','),
            (std::vector<std::string_view>{"a", R"("b,c")", R"("d\",e")", ""}));
  EXPECT_TRUE(value_names("Keep-Alive, CLOSE", "close"));
  EXPECT_FALSE(value_names("closed", "close"));
}

TEST(HeaderValue, FindsParametersHoweverTheyAreWritten) {
  EXPECT_EQ(parameter_of("multipart/form-data; Boundary = \"a;b=c\"", "boundary"), "a;b=c");
  EXPECT_EQ(parameter_of("multipart/form-data; boundary=----=_Part_1", "boundary"), "----=_Part_1");
  EXPECT_EQ(parameter_of(R"(x; a="q\"q")", "a"), "q\"q");
  EXPECT_EQ(parameter_of("multipart/form-data", "boundary"), std::nullopt);
  EXPECT_EQ(quality_of("gzip;q=0.25"), 0.25);
  EXPECT_EQ(quality_of("gzip"), 1);
  for (const char* bad : {"gzip;q=2", "gzip;q=x", "gzip;q=-1", "gzip;q=", "gzip;q=nan"})
    EXPECT_EQ(quality_of(bad), 0) << bad;
}

TEST(Gzip, IsAcceptedByTheQualitiesThatTheHeaderGives) {
  for (const char* yes : {"gzip", "GZIP", "x-gzip", "deflate, gzip;q=0.5", "*", "br;q=1, *;q=0.1",
                          "identity;q=0.5, gzip", "gzip, identity"}) {
    EXPECT_TRUE(accepts_gzip(yes)) << yes;
  }
  for (const char* no : {"", "identity", "gzip;q=0", "br, deflate", "*;q=0", "*, gzip;q=0", "gzip;q=0.000",
                         "identity, gzip;q=0.5", "gzipped"}) {
    EXPECT_FALSE(accepts_gzip(no)) << no;
  }
}

TEST(Gzip, ComesBackAsItWas) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, std::size_t{1'000'000}}) {
    const std::string text = mixed_text(size);
    const auto packed = gzip(text, never);
    ASSERT_TRUE(packed.has_value());
    for (const std::size_t at_once : {std::size_t{1}, std::size_t{7}, std::size_t{65536}}) {
      const auto plain = inflated(*packed, at_once);
      ASSERT_TRUE(plain.ok()) << plain.error().message;
      EXPECT_EQ(plain.value(), text);
    }
  }
}

TEST(Gzip, StopsWhenNobodyWantsItAnyMore) {
  int asked = 0;
  EXPECT_FALSE(gzip(mixed_text(2'000'000), [&] { return ++asked == 3; }).has_value());
  EXPECT_EQ(asked, 3);
}

TEST(Inflater, TakesJoinedFilesAndDeflate) {
  const std::string text = mixed_text(10'000);
  const std::string packed = *gzip(text, never);
  EXPECT_EQ(inflated(packed + packed, 100).value(), text + text);
  std::string deflated(compressBound(text.size()), '\0');
  uLongf size = deflated.size();
  compress(reinterpret_cast<Bytef*>(deflated.data()), &size, reinterpret_cast<const Bytef*>(text.data()),
           text.size());
  EXPECT_EQ(inflated(deflated.substr(0, size), 100).value(), text);
}

TEST(Inflater, RefusesEveryCutAndWhatIsNotCompressed) {
  const std::string packed = *gzip(mixed_text(2000), never);
  for (std::size_t size = 1; size < packed.size(); ++size) {
    const auto cut = inflated(packed.substr(0, size), 64);
    ASSERT_FALSE(cut.ok()) << size;
    EXPECT_EQ(cut.error().cause, Cause::BadRequest);
  }
  EXPECT_EQ(inflated("v 0 0 0\n", 64).error().cause, Cause::BadRequest);
  std::string flipped = packed;
  flipped[flipped.size() - 8] ^= 1;  // of the checksum
  EXPECT_EQ(inflated(flipped, 64).error().cause, Cause::BadRequest);
}

TEST(Inflater, StopsWithItsSink) {
  const std::string packed = *gzip(std::string(10'000'000, '\0'), never);
  Inflater inflater;
  std::size_t taken = 0;
  const auto fed = inflater.feed(packed, [&](std::string_view piece) -> Result<> {
    taken += piece.size();
    if (taken > 100'000) return Error{Cause::TooLarge, "enough"};
    return {};
  });
  EXPECT_EQ(fed.error().cause, Cause::TooLarge);
  EXPECT_LT(taken, 200'000u);
}

TEST(BodyDecoder, HandsOnLargePieces) {
  auto decoder = BodyDecoder::for_encoding("Identity").value();
  std::size_t pieces = 0, bytes = 0;
  const ByteSink sink = [&](std::string_view piece) {
    ++pieces;
    bytes += piece.size();
    return Result<>();
  };
  for (int i = 0; i < 200'000; ++i) ASSERT_TRUE(decoder->feed("x", sink).ok());
  ASSERT_TRUE(decoder->finish(sink).ok());
  EXPECT_EQ(bytes, 200'000u);
  EXPECT_LE(pieces, 4u);
}

TEST(HttpPatience, WaitsAsLongAsTheAverageRateHolds) {
  const HttpPatience patience{.stall = seconds(30), .min_body_rate = 1000};
  const auto now = Connection::Clock::now();
  EXPECT_EQ(patience.deadline(now, seconds(10), 0), now + seconds(10));
  EXPECT_EQ(patience.deadline(now, seconds(10), 5000), now + seconds(15));
  const auto after_much = patience.deadline(now, seconds(10), std::uint64_t{1} << 60);
  EXPECT_LE(after_much, Connection::Clock::now() + seconds(30)) << "who was fast may not stall for long";
  const HttpPatience any{.stall = seconds(30), .min_body_rate = 0};
  EXPECT_GE(any.deadline(now - seconds(100), seconds(10), 0), now + seconds(30));
}

TEST(RequestReader, FindsHeadsAndHidesRanges) {
  MemoryConnection client("\r\nGET / HTTP/1.1\r\nrange: bytes=9-1\r\nHost: x\r\nRanges: 1\r\n\r\nbodyGET");
  const HttpPatience patience;
  RequestReader reader(client, patience);
  ASSERT_EQ(reader.read_head(true), RequestReader::Head::Whole);
  std::string read(200, '\0');
  read.resize(static_cast<std::size_t>(reader.read(read.data(), read.size())));
  EXPECT_EQ(read, "GET / HTTP/1.1\r\nHost: x\r\nRanges: 1\r\n\r\n");
  EXPECT_EQ(reader.read(read.data(), 1), 0) << "the body has not begun";
  reader.begin_body();
  EXPECT_EQ(reader.read(read.data(), 3), 3);
  reader.end_body();
  EXPECT_EQ(reader.read(read.data(), 1), -1);
  EXPECT_TRUE(reader.skip(1));
  EXPECT_EQ(reader.body_bytes(), 4u);
  EXPECT_EQ(reader.read_head(false), RequestReader::Head::Cut);
  EXPECT_EQ(reader.read_head(false), RequestReader::Head::None);
}

TEST(RequestReader, BoundsTheHead) {
  const HttpPatience patience;
  std::string lines;
  while (lines.size() < 100'000) lines += "a: b\r\n";
  for (const std::string& filler : {std::string(100'000, 'a'), lines}) {
    const std::string bytes = "GET / HTTP/1.1\r\n" + filler;
    MemoryConnection client(bytes);
    RequestReader reader(client, patience);
    EXPECT_EQ(reader.read_head(true), RequestReader::Head::TooLarge);
  }
}

TEST(ConnectionThreads, RunsAllAtOnceAndRefusesMore) {
  ConnectionThreads threads(3);
  std::promise<void> open;
  const auto opened = open.get_future().share();
  std::promise<void> all_run;
  std::atomic<int> running = 0;
  const auto work = [&] {
    if (++running == 3) all_run.set_value();
    opened.wait();
  };
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(threads.run(work));
  all_run.get_future().wait();
  EXPECT_FALSE(threads.run(work));
  EXPECT_EQ(threads.busy(), 3u);
  EXPECT_FALSE(threads.wait_until_idle(milliseconds(1)));
  open.set_value();
  EXPECT_TRUE(threads.wait_until_idle(seconds(60)));
  std::promise<void> again;
  EXPECT_TRUE(threads.run([&] { again.set_value(); }));
  again.get_future().wait();
}

TEST(ConnectionThreads, NeverLetsWorkWaitForABusyThread) {
  ConnectionThreads threads(100);
  for (int round = 0; round < 200; ++round) {
    std::promise<void> second_ran;
    const auto second = second_ran.get_future().share();
    ASSERT_TRUE(threads.run([second] { second.wait(); }));
    ASSERT_TRUE(threads.run([&second_ran] { second_ran.set_value(); }));
    ASSERT_TRUE(threads.wait_until_idle(seconds(60)));
  }
}

}  // namespace
}  // namespace burnish
