#include "bench/contacts/image_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bench/contacts/image_moments.h"

namespace ertbench {
namespace {

constexpr int no_hill = -1;

}  // namespace

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
    // Between a positive pixel and a negative one the change is zero somewhere: no way leads on.
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
  // Pixels come from the highest down, so that where two hills first touch is the highest way
  // between them.
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
    if (hill.parent != static_cast<int>(h) || hill.pixels < rule.least_pixels) continue;
    contacts.push_back(
        {hill.moment / hill.weight, hill.weight * area, hill.peak, hill.pixels * area});
  }
  std::stable_sort(
      contacts.begin(), contacts.end(),
      [](const FoundContact& a, const FoundContact& b) { return a.strength > b.strength; });
}

std::vector<FoundContact> contacts_of_image(const Sensor& sensor, const ContactRule& rule,
                                            const Eigen::Ref<const Eigen::RowVectorXd>& change) {
  std::vector<FoundContact> contacts;
  ContactReader(sensor).read(rule, change, contacts);
  return contacts;
}

}  // namespace ertbench
