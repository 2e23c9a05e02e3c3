#include "runtime/runtime.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include "runtime/layer_file.h"
#include "runtime/layer_plan.h"

namespace ertbench::runtime {
namespace {

// The rule of the exported C code, from one source.
using ErtContact = Contact;
constexpr std::int32_t most_contacts = 8;
constexpr int most_pixels = INT16_MAX;

struct ErtHills {
  std::uint16_t* order;  ///< [pixels]
  std::int16_t* hill;    ///< [pixels]
  float* weight;         ///< [pixels]
  std::int32_t columns;
  std::int32_t pixels;
  const LayerFile* rule;
};

#define ERT_PIXELS hills->pixels
#define ERT_COLUMNS hills->columns
#define ERT_MOST_CONTACTS most_contacts
#define ERT_THRESHOLD hills->rule->threshold
#define ERT_FLOOR hills->rule->floor
#define ERT_SADDLE hills->rule->saddle
#define ERT_X_MM hills->rule->x_mm
#define ERT_Y_MM hills->rule->y_mm
#define ERT_WIDTH_MM hills->rule->width_mm
#define ERT_HEIGHT_MM hills->rule->height_mm

typedef union {
  float value;
  std::uint32_t bits;
} ErtFloat;

using std::int16_t;
using std::int32_t;
using std::uint16_t;
using std::uint32_t;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include "runtime/contacts.c.in"
#pragma GCC diagnostic pop

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

}  // namespace

struct Solver::State {
  LayerFile file;
  std::unique_ptr<InferencePlan> plan;
  std::vector<float> reference;
  std::vector<float> changes;
  std::vector<float> weight;
  std::vector<std::uint16_t> order;
  std::vector<std::int16_t> hill;
  ErtHills hills;
  std::vector<Contact> contacts = std::vector<Contact>(most_contacts);

  State(LayerFile loaded, std::size_t pixels)
      : file(std::move(loaded)),
        plan(plan_of(file.list, file.channels, static_cast<int>(pixels))),
        reference(file.reference),
        changes(file.reference.size()),
        weight(pixels),
        order(pixels),
        hill(pixels),
        hills{order.data(),
              hill.data(),
              weight.data(),
              file.columns,
              static_cast<std::int32_t>(pixels),
              &file} {}
  std::size_t pixels() const { return hill.size(); }
};

namespace {

/// Throws std::runtime_error for a file whose lists do not belong together.
void check(const LayerFile& file) {
  const auto channels = static_cast<std::size_t>(std::max(0, file.channels));
  const bool scaled = file.list.shift.size() == channels && file.list.scale.size() == channels;
  bool sound = file.channels > 0 && file.rows > 0 && file.columns > 0 && file.rows <= most_pixels &&
               file.columns <= most_pixels / file.rows && file.reference.size() == channels &&
               (scaled || (file.list.shift.empty() && file.list.scale.empty()));
  for (const int pixel : file.no_sheet) {
    sound = sound && pixel >= 0 && pixel < file.rows * file.columns;
  }
  if (!sound) throw std::runtime_error("is damaged (its sizes contradict each other)");
}

}  // namespace

Solver Solver::load(const std::string& name, const std::string& folder) {
  const bool is_file = std::filesystem::is_regular_file(name);
  const std::string path = is_file ? name : folder + "/" + name + ".ert";
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    throw std::runtime_error(path + ": there is no such file; write it by `ertbench export " +
                             name + " --to runtime --out " + folder + "`");
  }
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  try {
    LayerFile file = layer_file_from(bytes);
    check(file);
    const auto pixels = static_cast<std::size_t>(file.rows * file.columns);
    return Solver(std::make_unique<State>(std::move(file), pixels));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

Solver::Solver(std::unique_ptr<State> state) : state_(std::move(state)) {}
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;
Solver::~Solver() = default;

const std::string& Solver::name() const { return state_->file.name; }
int Solver::channels() const { return state_->file.channels; }
int Solver::rows() const { return state_->file.rows; }
int Solver::columns() const { return state_->file.columns; }

void Solver::set_reference(std::span<const float> voltages) {
  require(voltages.size() == state_->reference.size(),
          "the reference has another size than a frame");
  std::copy(voltages.begin(), voltages.end(), state_->reference.begin());
}

void Solver::reconstruct(std::span<const float> voltages, std::span<float> image) {
  State& state = *state_;
  require(voltages.size() == state.changes.size(), "a frame of another size");
  require(image.size() == state.pixels(), "an image of another size");
  for (std::size_t i = 0; i < voltages.size(); ++i) {
    state.changes[i] = voltages[i] - state.reference[i];
  }
  const std::vector<float>& scale = state.file.list.scale;
  for (std::size_t i = 0; i < scale.size(); ++i) {
    state.changes[i] = (state.changes[i] - state.file.list.shift[i]) * scale[i];
  }
  state.plan->run(state.changes.data(), image.data());
  const auto unit = static_cast<float>(state.file.list.unit);
  for (float& pixel : image) pixel *= unit;
  for (const int pixel : state.file.no_sheet) image[static_cast<std::size_t>(pixel)] = 0;
}

int Solver::contacts(std::span<const float> image, std::span<Contact> contacts) {
  State& state = *state_;
  require(image.size() == state.pixels(), "an image of another size");
  const int found = ert_find(&state.hills, image.data(), state.contacts.data());
  const int count = std::min(found, static_cast<int>(contacts.size()));
  std::copy_n(state.contacts.begin(), count, contacts.begin());
  return count;
}

}  // namespace ertbench::runtime
