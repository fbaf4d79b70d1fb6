// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/mcap/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "merge.hpp"
#include "read/scanner.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::mcap {
namespace {

/// Messages outside of chunks that are read together.
constexpr std::uint64_t stretch_bytes{std::uint64_t{1} << 20};

/// Selection of messages.
struct Filter {
  std::set<std::uint16_t> channels;
  std::uint64_t first_ns, last_ns;

  [[nodiscard]] bool takes(const MessagePlace& message) const {
    return message.log_time_ns >= first_ns && message.log_time_ns <= last_ns && channels.contains(message.channel);
  }
  [[nodiscard]] bool may_take(const Place& place) const {
    if (place.first_ns > last_ns || place.last_ns < first_ns) return false;
    return place.channels.empty() ||
           std::ranges::any_of(place.channels, [&](std::uint16_t channel) { return channels.contains(channel); });
  }
};

void add_place(std::vector<Place>& places, const Place& place) {
  if (!places.empty() && !places.back().is_chunk && !place.is_chunk &&
      place.offset + place.length - places.back().offset <= stretch_bytes) {
    Place& stretch{places.back()};
    stretch.length = place.offset + place.length - stretch.offset;
    stretch.first_ns = std::min(stretch.first_ns, place.first_ns);
    stretch.last_ns = std::max(stretch.last_ns, place.last_ns);
    stretch.channels.clear();
    return;
  }
  places.push_back(place);
}

}  // namespace

struct Reader::State {
  explicit State(const std::filesystem::path& path) : file{path} {
    require_mcap(file);
    try {
      SummarySection summary{read_summary(file)};
      if (summary.is_complete) {
        contents = std::move(summary.contents);
        read_header(file, contents);
        places = std::move(summary.chunks);
        is_indexed = true;
        return;
      }
    } catch (const Malformed&) {  // the scanner finds that, too, and more
    }
    Scanner scanner{file};
    while (scanner.next()) add_place(places, scanner.place());
    contents = scanner.contents();
    damage = scanner.damage();
  }

  void skip(const Place& place, const char* why) {
    if (!skipped.insert(place.offset).second) return;
    damage.chunks_skipped += place.is_chunk ? 1 : 0;
    note(damage, fmt::format("At byte {} {} of {} bytes is skipped: {}.", place.offset,
                             place.is_chunk ? "a chunk" : "a stretch of messages", place.length, why));
  }

  FileInput file;
  Contents contents;
  std::vector<Place> places;
  bool is_indexed{false};
  Damage damage;
  std::set<std::uint64_t> skipped;  // offsets
  std::uint64_t unpacked_bytes{0};  // sum over all cursors
};

namespace {

/// Messages of one place in the order of their times.
class PlaceCursor : public MessageCursor {
 public:
  PlaceCursor(Batch batch, std::uint64_t& unpacked_bytes)
      : batch_{std::move(batch)}, held_{batch_.memory_bytes()}, unpacked_bytes_{unpacked_bytes} {
    unpacked_bytes_ += held_;
  }
  ~PlaceCursor() override { unpacked_bytes_ -= held_; }

  const Message* next() override {
    if (next_ == batch_.messages.size()) return nullptr;
    message_ = batch_.message(batch_.messages[next_++]);
    return &message_;
  }

 private:
  Batch batch_;
  std::size_t next_{0};
  Message message_;
  std::uint64_t held_;
  std::uint64_t& unpacked_bytes_;
};

}  // namespace

Reader::Reader(const std::filesystem::path& path) : state_{std::make_shared<State>(path)} {}
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;
Reader::~Reader() = default;

const Contents& Reader::contents() const {
  return state_->contents;
}

bool Reader::is_indexed() const {
  return state_->is_indexed;
}

const Damage& Reader::damage() const {
  return state_->damage;
}

std::unique_ptr<MessageCursor> Reader::messages(const Selection& selection) const {
  Filter filter{{}, selection.first_ns, selection.last_ns};
  for (const auto& [id, channel] : state_->contents.channels) {
    if (selection.topics.empty() || std::ranges::find(selection.topics, channel.topic) != selection.topics.end()) {
      filter.channels.insert(id);
    }
  }
  std::vector<std::size_t> wanted;
  std::vector<std::uint64_t> first_ns;
  for (std::size_t i{0}; i < state_->places.size(); ++i) {
    if (!filter.may_take(state_->places[i])) continue;
    wanted.push_back(i);
    first_ns.push_back(state_->places[i].first_ns);
  }
  return std::make_unique<MergeByTime>(
      first_ns, [state = state_, filter, wanted](std::size_t source) -> std::unique_ptr<MessageCursor> {
        const Place& place{state->places[wanted[source]]};
        Batch batch;
        try {
          load(state->file, place, batch);
          std::erase_if(batch.messages, [&](const MessagePlace& message) { return !filter.takes(message); });
          std::ranges::stable_sort(batch.messages, {}, &MessagePlace::log_time_ns);
          if (!batch.messages.empty() && batch.messages.front().log_time_ns < place.first_ns) {
            throw Malformed{"it has messages of earlier times than the summary says"};  // others were given already
          }
        } catch (const Malformed& wrong) {
          state->skip(place, wrong.what());
          return nullptr;
        }
        if (state->unpacked_bytes + batch.memory_bytes() > most_unpacked_bytes) {
          throw InputError{state->file.name(),
                           fmt::format("chunks of more than 1 GiB overlap at byte {}.", place.offset),
                           "Sort the file (mcap sort), or ask for fewer topics."};
        }
        return std::make_unique<PlaceCursor>(std::move(batch), state->unpacked_bytes);
      });
}

class StreamReader::Implementation {
 public:
  explicit Implementation(const std::filesystem::path& path) : file_{path}, scanner_{file_} {}

  const Message* next() {
    if (!is_done_ && next_ == scanner_.batch().messages.size()) {
      next_ = 0;
      is_done_ = !scanner_.next();
    }
    if (is_done_) return nullptr;
    message_ = scanner_.batch().message(scanner_.batch().messages[next_++]);
    return &message_;
  }

  [[nodiscard]] const Scanner& scanner() const { return scanner_; }

 private:
  FileInput file_;
  Scanner scanner_;
  std::size_t next_{0};
  bool is_done_{false};
  Message message_;
};

StreamReader::StreamReader(const std::filesystem::path& path)
    : implementation_{std::make_unique<Implementation>(path)} {}

StreamReader::~StreamReader() = default;

const Message* StreamReader::next() {
  return implementation_->next();
}

const Contents& StreamReader::contents() const {
  return implementation_->scanner().contents();
}

const Damage& StreamReader::damage() const {
  return implementation_->scanner().damage();
}

}  // namespace stereogrid::mcap
