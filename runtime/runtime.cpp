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
using std::log10;
using std::uint16_t;
using std::uint32_t;
using std::uint64_t;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include "runtime/contacts.c.in"
#include "runtime/front.c.in"
#pragma GCC diagnostic pop

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

/// What is done with a frame before its layers.
struct FrontState {
  std::vector<std::uint16_t> pairs;
  std::vector<std::uint16_t> least_bad;
  std::vector<float> reference;
  ErtFrontModel model = {};
  std::uint64_t known = 0;
  std::vector<double> products;
  std::vector<double> work;

  explicit FrontState(const FrameFront& front)
      : pairs(front.pairs.begin(), front.pairs.end()),
        least_bad(front.least_bad.begin(), front.least_bad.end()),
        reference(front.reference.begin(), front.reference.end()) {
    if (front.electrodes == 0) return;
    const std::size_t directions = front.directions.size() / front.users.size();
    products.resize(directions * (directions + 1) / 2);
    work.resize(products.size() + directions);
    model = {.channels = static_cast<int>(reference.size()),
             .electrodes = front.electrodes,
             .pairs = static_cast<int>(front.users.size()),
             .directions = static_cast<int>(directions),
             .told = front.told,
             .neighbours = front.neighbours,
             .of_change = front.of_change,
             .noise = front.noise,
             .noise_slope = front.noise_slope,
             .limit = front.limit,
             .least_size = front.least_size,
             .residual = front.residual,
             .residual_slope = front.residual_slope,
             .reference_square = front.reference_square,
             .pair = pairs.data(),
             .users = front.users.data(),
             .least_bad = least_bad.data(),
             .reference = reference.data(),
             .direction = front.directions.data()};
  }
  FrontState(const FrontState&) = delete;
  FrontState& operator=(const FrontState&) = delete;
};

}  // namespace

struct Solver::State {
  LayerFile file;
  FrontState front;
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
        front(file.front),
        plan(plan_of(file.list, file.channels + file.front.told, static_cast<int>(pixels))),
        reference(file.reference),
        changes(file.reference.size() + static_cast<std::size_t>(file.front.told)),
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

bool is_sound(const FrameFront& front, std::size_t channels) {
  constexpr std::size_t most_directions = 64;
  if (front.electrodes == 0) return front.told == 0;
  const std::size_t pairs = front.users.size();
  const auto is_channel = [&](int c) { return c >= 0 && static_cast<std::size_t>(c) < channels; };
  return front.electrodes > 0 && front.electrodes <= 64 &&
         (front.told == 0 || front.told == front.electrodes + 1) && pairs > 0 &&
         front.pairs.size() == 2 * pairs &&
         std::all_of(front.pairs.begin(), front.pairs.end(), is_channel) &&
         front.least_bad.size() == static_cast<std::size_t>(front.electrodes) &&
         front.reference.size() == channels && !front.directions.empty() &&
         front.directions.size() % pairs == 0 && front.directions.size() / pairs <= most_directions;
}

/// Throws std::runtime_error for a file whose lists do not belong together.
void check(const LayerFile& file) {
  const auto channels = static_cast<std::size_t>(std::max(0, file.channels));
  const bool scaled = file.list.shift.size() == channels && file.list.scale.size() == channels;
  bool sound = file.channels > 0 && file.rows > 0 && file.columns > 0 && file.rows <= most_pixels &&
               file.columns <= most_pixels / file.rows && file.reference.size() == channels &&
               (scaled || (file.list.shift.empty() && file.list.scale.empty())) &&
               is_sound(file.front, channels);
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
  try {
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
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
  if (state_->front.model.electrodes > 0) {
    ert_fill_reference(&state_->front.model, state_->changes.data(), state_->reference.data());
  }
}

void Solver::reconstruct(std::span<const float> voltages, std::span<float> image) {
  State& state = *state_;
  require(voltages.size() == state.reference.size(), "a frame of another size");
  require(image.size() == state.pixels(), "an image of another size");
  for (std::size_t i = 0; i < voltages.size(); ++i) {
    state.changes[i] = voltages[i] - state.reference[i];
  }
  FrontState& front = state.front;
  if (front.model.electrodes > 0) {
    ert_front(&front.model, &front.known, front.products.data(), front.work.data(),
              state.changes.data());
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
