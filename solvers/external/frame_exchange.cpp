#include "solvers/external/frame_exchange.h"

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "core/errors.h"

namespace ertbench {
namespace {

// The protocol's numbers are little-endian, and so are this machine's.
static_assert(std::endian::native == std::endian::little);

template <typename T>
std::string_view bytes_of(const T* values, std::size_t count) {
  return {reinterpret_cast<const char*>(values), count * sizeof(T)};
}

template <typename T>
std::span<char> room_of(T* values, std::size_t count) {
  return {reinterpret_cast<char*>(values), count * sizeof(T)};
}

template <typename Rows>
bool row_behind_row(const Rows& rows) {
  return rows.rows() == 1 || rows.outerStride() == rows.cols();
}

}  // namespace

void FrameExchange::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport> reports) {
  const std::lock_guard lock(one_at_a_time_);
  const auto frames = static_cast<std::uint64_t>(changes.rows());
  if (frames == 0) return;
  Frames dense_changes;
  Images dense_images;
  const double* sent = changes.data();
  double* received = images.data();
  if (!row_behind_row(changes)) {
    dense_changes = changes;
    sent = dense_changes.data();
  }
  const bool copied = !row_behind_row(images);
  if (copied) {
    dense_images.resize(images.rows(), images.cols());
    received = dense_images.data();
  }
  std::array<std::uint8_t, 64> few;
  std::vector<std::uint8_t> many(frames > few.size() ? frames : 0);
  std::uint8_t* const statuses = many.empty() ? few.data() : many.data();
  const std::array<std::string_view, 2> out = {
      bytes_of(&frames, 1), bytes_of(sent, static_cast<std::size_t>(changes.size()))};
  const std::array<std::span<char>, 2> in = {
      room_of(received, static_cast<std::size_t>(images.size())), room_of(statuses, frames)};
  program_.exchange(out, in, frame_limit_s_ * static_cast<double>(frames));
  if (copied) images = dense_images;
  for (std::uint64_t f = 0; f < frames; ++f) {
    if (statuses[f] > static_cast<std::uint8_t>(FrameStatus::suspect)) {
      throw FailedTrial("failed", "the program gave a frame the status " +
                                      std::to_string(statuses[f]) +
                                      "; it must be 0 (ok), 1 (not converged), 2 (undefined) or 3 "
                                      "(suspect): are there as many bytes as the protocol has?");
    }
    reports[f].status = static_cast<FrameStatus>(statuses[f]);
  }
}

}  // namespace ertbench
