#include "bench/score/image_contacts.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/score/assignment.h"
#include "core/arrays.h"
#include "core/statistics.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;

nlohmann::json or_auto(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json("auto");
}

using ImageRow = Eigen::Ref<const RowVectorXd>;

/// Weights whose sum is below this share of the sum of absolute weights have no centroid.
constexpr double kCancelled = 1e-3;

constexpr int no_hill = -1;

std::optional<Eigen::Vector2d> centroid_mm(const Sensor& sensor,
                                           const Eigen::Ref<const Eigen::RowVectorXd>& change) {
  if (is_empty(sensor, change)) return std::nullopt;
  std::optional<Eigen::Vector2d> place = centroid(sensor, change);
  if (place) *place *= sensor.sheet->unit_mm();
  return place;
}

/// Least relative improvement of the mean, so that rounding does not decide.
constexpr double kBetter = 1e-9;

/// Images of validation frames, with the true contact positions.
struct ImagesWithTruth {
  Images images;  ///< [frames, pixels] S/m
  std::vector<Eigen::Index> usable;
  std::vector<std::vector<Eigen::Vector2d>> places_mm;  ///< [frames]
};

ImagesWithTruth images_of(const Sensor& sensor, const Solver& solver,
                          const DatasetFile& validation) {
  const auto count = std::min<std::uint64_t>(frames_of_choice, validation.size());
  const Frames changes =
      validation.voltages(0, count).rowwise() - validation.reference_voltages().transpose();
  ImagesWithTruth out;
  out.images.resize(changes.rows(), sensor.pixels());
  std::vector<FrameReport> reports(count);
  solver.reconstruct(changes, out.images, reports);
  for (std::size_t f = 0; f < count; ++f) {
    const auto row = static_cast<Eigen::Index>(f);
    if (reports[f].status == FrameStatus::undefined || !out.images.row(row).allFinite()) continue;
    out.usable.push_back(row);
  }
  for (const Scene& scene : validation.scenes(0, count)) {
    out.places_mm.push_back(true_places_mm(sensor, scene));
  }
  return out;
}

double mean_ospa(const Sensor& sensor, const ContactRule& rule, double cutoff_mm,
                 const ImagesWithTruth& frames, ContactReader& reader) {
  double sum = 0;
  std::vector<FoundContact> found;
  for (const Eigen::Index f : frames.usable) {
    reader.read(rule, frames.images.row(f), found);
    sum += ospa(places_mm(sensor, found), frames.places_mm[static_cast<std::size_t>(f)], cutoff_mm);
  }
  return sum / static_cast<double>(frames.usable.size());
}

/// Floors to try, over the background.
std::vector<double> floors_for(const Sensor& sensor, const ImagesWithTruth& frames) {
  std::vector<double> peaks;
  for (const Eigen::Index f : frames.usable) {
    peaks.push_back(frames.images.row(f).cwiseAbs().maxCoeff() / sensor.background);
  }
  const double high = nearest_rank_quantile(SortedValues(std::move(peaks)), 0.9);
  std::vector<double> floors;
  for (const double part : floors_to_try) floors.push_back(part * high);
  return floors;
}

}  // namespace

ContactRule ContactSettings::rule() const {
  ContactRule rule;
  rule.threshold = threshold.value_or(rule.threshold);
  rule.floor = floor.value_or(rule.floor);
  rule.saddle = saddle;
  return rule;
}

ContactDistances ContactSettings::distances(const Sensor& sensor) const {
  const double side = sensor.sheet->size_mm().maxCoeff();
  return {match_mm.value_or(side / 10), ospa_mm.value_or(side / 4)};
}

nlohmann::json to_json(const ContactSettings& settings) {
  nlohmann::json json = {{"threshold", or_auto(settings.threshold)},
                         {"floor", or_auto(settings.floor)},
                         {"saddle", settings.saddle},
                         {"match_mm", or_auto(settings.match_mm)},
                         {"ospa_mm", or_auto(settings.ospa_mm)}};
  if (!settings.chosen_on.empty()) json["chosen_on"] = settings.chosen_on;
  return json;
}

bool is_empty(const Sensor& sensor, const ImageRow& change) {
  return change.cwiseAbs().maxCoeff() <= kEmptyImage * sensor.background;
}

bool cancels(const ImageRow& weights) {
  return std::abs(weights.sum()) <= kCancelled * weights.cwiseAbs().sum();
}

RowVectorXd thresholded(const ImageRow& change, double fraction) {
  const double limit = fraction * (1 - kThresholdSlack) * change.cwiseAbs().maxCoeff();
  return (change.array().abs() >= limit).select(change, 0.0);
}

std::optional<Eigen::Vector2d> centroid(const Sensor& sensor, const ImageRow& change) {
  if (cancels(change)) return std::nullopt;
  const PixelGrid pixels = sensor.image();
  const Eigen::Map<const RowMajorMatrix> image(change.data(), pixels.rows(), pixels.columns());
  const double x = image.colwise().sum().dot(pixels.centres_x());
  const double y = image.rowwise().sum().dot(pixels.centres_y());
  return Eigen::Vector2d(x, y) / change.sum();
}

ContactReader::ContactReader(const Sensor& sensor)
    : background_(sensor.background),
      pixels_(sensor.image()),
      hill_(static_cast<std::size_t>(sensor.pixels()), no_hill) {
  for (int p = 0; p < pixels_.count(); ++p) centres_.push_back(pixels_.centre(p));
}

int ContactReader::hill_of(int pixel) {
  int hill = hill_[static_cast<std::size_t>(pixel)];
  if (hill == no_hill) return no_hill;
  const auto parent = [&](int h) -> int& { return hills_[static_cast<std::size_t>(h)].parent; };
  while (parent(hill) != hill) hill = parent(hill) = parent(parent(hill));
  return hill_[static_cast<std::size_t>(pixel)] = hill;
}

int ContactReader::unite(int a, int b) {
  if (hills_[static_cast<std::size_t>(a)].peak < hills_[static_cast<std::size_t>(b)].peak) {
    std::swap(a, b);
  }
  Hill& higher = hills_[static_cast<std::size_t>(a)];
  Hill& lower = hills_[static_cast<std::size_t>(b)];
  lower.parent = a;
  higher.weight += lower.weight;
  higher.moment += lower.moment;
  higher.pixels += lower.pixels;
  return a;
}

int ContactReader::climb(const Pixel& at, const double* change, double saddle) {
  const auto [height, pixel] = at;
  const bool positive = change[pixel] > 0;
  const int column = pixel % pixels_.columns();
  const int row = pixel / pixels_.columns();
  std::array<int, 4> touched{};
  std::size_t count = 0;
  int home = no_hill;
  double steepest = 0;
  const auto look = [&](int neighbour) {
    // The change is zero somewhere between pixels of different signs, which separates them.
    const int hill = hill_of(neighbour);
    if (hill == no_hill || (change[neighbour] > 0) != positive) return;
    touched[count++] = hill;
    if (std::abs(change[neighbour]) <= steepest) return;
    steepest = std::abs(change[neighbour]);
    home = hill;
  };
  if (column > 0) look(pixel - 1);
  if (column + 1 < pixels_.columns()) look(pixel + 1);
  if (row > 0) look(pixel - pixels_.columns());
  if (row + 1 < pixels_.rows()) look(pixel + pixels_.columns());
  if (home == no_hill) {
    hills_.push_back({static_cast<int>(hills_.size()), height, 0, Eigen::Vector2d::Zero(), 0});
    return hills_.back().parent;
  }
  // Pixels come in descending order, so that two hills first touch at the saddle between them.
  for (std::size_t i = 0; i < count; ++i) {
    int other = touched[i];
    while (hills_[static_cast<std::size_t>(other)].parent != other) {
      other = hills_[static_cast<std::size_t>(other)].parent;
    }
    if (other == home) continue;
    const double lower = std::min(hills_[static_cast<std::size_t>(home)].peak,
                                  hills_[static_cast<std::size_t>(other)].peak);
    if (height >= saddle * lower) home = unite(home, other);
  }
  return home;
}

void ContactReader::find(const Solver& solver, const ContactRule& rule, FramesView changes,
                         std::span<std::vector<FoundContact>> contacts) {
  if (const ContactFinder* finder = solver.contact_finder()) {
    return finder->find_contacts(changes, contacts);
  }
  Images images(changes.rows(), pixels_.count());
  std::vector<FrameReport> reports(contacts.size());
  solver.reconstruct(changes, images, reports);
  for (std::size_t f = 0; f < contacts.size(); ++f) {
    const auto image = images.row(static_cast<Eigen::Index>(f));
    if (reports[f].status == FrameStatus::undefined || !image.allFinite()) continue;
    read(rule, image, contacts[f]);
  }
}

void ContactReader::read(const ContactRule& rule,
                         const Eigen::Ref<const Eigen::RowVectorXd>& change,
                         std::vector<FoundContact>& contacts) {
  contacts.clear();
  double peak = 0;
  for (int p = 0; p < pixels_.count(); ++p) {
    if (pixels_.on_sheet(p)) peak = std::max(peak, std::abs(change[p]));
  }
  const double limit =
      (1 - kThresholdSlack) *
      std::max({rule.threshold * peak, rule.floor * background_, kEmptyImage * background_});
  if (peak < limit) return;
  order_.clear();
  hills_.clear();
  for (int p = 0; p < pixels_.count(); ++p) {
    hill_[static_cast<std::size_t>(p)] = no_hill;
    const double height = std::abs(change[p]);
    if (height >= limit && pixels_.on_sheet(p)) order_.push_back({height, p});
  }
  std::sort(order_.begin(), order_.end());
  for (const Pixel& pixel : order_) {
    const int home = climb(pixel, change.data(), rule.saddle);
    hill_[static_cast<std::size_t>(pixel.index)] = home;
    Hill& hill = hills_[static_cast<std::size_t>(home)];
    hill.weight += pixel.height;
    hill.moment += pixel.height * centres_[static_cast<std::size_t>(pixel.index)];
    ++hill.pixels;
  }
  const double area = pixels_.pixel_area();
  for (std::size_t h = 0; h < hills_.size(); ++h) {
    const Hill& hill = hills_[h];
    if (hill.parent != static_cast<int>(h)) continue;
    contacts.push_back(
        {hill.moment / hill.weight, hill.weight * area, hill.peak, hill.pixels * area});
  }
  std::ranges::stable_sort(contacts, [](const FoundContact& a, const FoundContact& b) {
    return a.strength > b.strength;
  });
}

std::vector<FoundContact> contacts_of_image(const Sensor& sensor, const ContactRule& rule,
                                            const Eigen::Ref<const Eigen::RowVectorXd>& change) {
  std::vector<FoundContact> contacts;
  ContactReader(sensor).read(rule, change, contacts);
  return contacts;
}

FrameReading frame_reading(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           std::span<const FoundContact> contacts) {
  const double mm = sensor.sheet->unit_mm();
  FrameReading out;
  for (const FoundContact& contact : contacts) {
    out.contacts.push_back(
        {contact.place * mm, contact.strength * mm * mm, contact.peak, contact.area * mm * mm});
  }
  Eigen::Index highest = 0;
  change.cwiseAbs().maxCoeff(&highest);
  out.peak = change[highest];
  out.sum = change.sum() * sensor.image().pixel_area() * mm * mm;
  out.centroid_mm = centroid_mm(sensor, change);
  out.centroid25_mm = centroid_mm(sensor, thresholded(change, 0.25));
  return out;
}

std::vector<Eigen::Vector2d> true_places_mm(const Sensor& sensor, const Scene& scene) {
  std::vector<Eigen::Vector2d> places;
  for (const Contact& contact : scene.contacts) {
    const Eigen::Vector2d place = contact.centroid();
    if (sensor.sheet->depth(place) >= 0) places.emplace_back(place * sensor.sheet->unit_mm());
  }
  return places;
}

std::vector<Eigen::Vector2d> places_mm(const Sensor& sensor, std::span<const FoundContact> found) {
  std::vector<Eigen::Vector2d> places;
  for (const FoundContact& contact : found) {
    places.emplace_back(contact.place * sensor.sheet->unit_mm());
  }
  return places;
}

ContactRuleChoice choose_contact_rule(const ContactSettings& settings, const Sensor& sensor,
                                      const Solver& solver, const DatasetFile* validation) {
  ContactRuleChoice out{settings.rule(), 0};
  if (!validation || (settings.threshold && settings.floor)) return out;
  const ImagesWithTruth frames = images_of(sensor, solver, *validation);
  if (frames.usable.empty()) return out;
  out.frames = static_cast<int>(frames.usable.size());
  std::vector<double> thresholds(thresholds_to_try.begin(), thresholds_to_try.end());
  if (settings.threshold) thresholds = {*settings.threshold};
  const std::vector<double> floors =
      settings.floor ? std::vector{*settings.floor} : floors_for(sensor, frames);
  const double cutoff = settings.distances(sensor).ospa;
  ContactReader reader(sensor);
  double least = mean_ospa(sensor, out.rule, cutoff, frames, reader);
  ContactRule rule = out.rule;
  for (const double threshold : thresholds) {
    for (const double floor : floors) {
      rule.threshold = threshold;
      rule.floor = floor;
      const double mean = mean_ospa(sensor, rule, cutoff, frames, reader);
      if (mean >= (1 - kBetter) * least) continue;
      least = mean;
      out.rule = rule;
    }
  }
  return out;
}

nlohmann::json to_json(const ContactRuleChoice& choice) {
  return {{"threshold", choice.rule.threshold},
          {"floor", choice.rule.floor},
          {"saddle", choice.rule.saddle},
          {"chosen_on", choice.frames}};
}

}  // namespace ertbench
