#include "forward/touch/skin_touch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "forward/touch/contact_law.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

/// The patches of a skin as boxes, in mm from the sheet's centre.
class Patches {
 public:
  Patches(const Skin& skin, double side_mm)
      : count_(skin.patches),
        pitch_(side_mm / skin.patches),
        half_(skin.patch_mm / 2),
        low_(-side_mm / 2) {}

  int count() const { return count_; }
  double width() const { return 2 * half_ / pitch_; }

  Eigen::AlignedBox2d box(int column, int row) const {
    const Vector2d centre(low_ + (column + 0.5) * pitch_, low_ + (row + 0.5) * pitch_);
    return {centre.array() - half_, centre.array() + half_};
  }

  /// Calls `use(index, box)` for the patches that may touch the box.
  template <typename Use>
  void near(const Eigen::AlignedBox2d& box, const Use& use) const {
    const auto index = [&](double mm) {
      return static_cast<int>(
          std::floor(std::clamp((mm - low_) / pitch_, -1.0, static_cast<double>(count_))));
    };
    const int left = std::max(0, index(box.min().x()));
    const int right = std::min(count_ - 1, index(box.max().x()));
    const int top = std::min(count_ - 1, index(box.max().y()));
    for (int row = std::max(0, index(box.min().y())); row <= top; ++row) {
      for (int column = left; column <= right; ++column) {
        use(column + count_ * row, this->box(column, row));
      }
    }
  }

 private:
  int count_;
  double pitch_;
  double half_;
  double low_;
};

const Skin& skin_of(const Sensor& sensor) {
  if (!sensor.skin) throw std::logic_error("touches need a sensor with a skin");
  return *sensor.skin;
}

double side_mm(const Sensor& sensor) { return sensor.sheet->size_mm().x(); }

/// The footprint in domain units, with the ratio of its most pressed patch.
Contact contact_of(const Sensor& sensor, const Patches& patches, const Touch& touch,
                   const VectorXd& pressure_kPa) {
  const Skin& skin = skin_of(sensor);
  const Vector2d middle = sensor.sheet->bounds().center();
  const double unit = sensor.sheet->unit_mm();
  Contact contact = footprint_mm(touch, skin.foam);
  double most = 0;
  patches.near(contact.bounds(), [&](int patch, const Eigen::AlignedBox2d&) {
    most = std::max(most, pressure_kPa[patch]);
  });
  contact.conductivity_ratio = conductivity_ratio(skin.law, most);
  contact.centre = middle + contact.centre / unit;
  contact.half_size /= unit;
  for (Vector2d& vertex : contact.vertices) vertex = middle + vertex / unit;
  return contact;
}

}  // namespace

VectorXd relaxed_pressure_kPa(const Sensor& sensor, std::span<const Touch> touches) {
  const Skin& skin = skin_of(sensor);
  const Patches patches(skin, side_mm(sensor));
  VectorXd pressure = VectorXd::Zero(skin.patches * skin.patches);
  for (const Touch& touch : touches) {
    if (touch.force_N <= 0) continue;
    patches.near(footprint_mm(touch, skin.foam).bounds(),
                 [&](int patch, const Eigen::AlignedBox2d& box) {
                   pressure[patch] += mean_pressure_kPa(touch, skin.foam, box);
                 });
  }
  return pressure;
}

Scene skin_scene(const Sensor& sensor, std::span<const Touch> touches,
                 const VectorXd& pressure_kPa) {
  const Skin& skin = skin_of(sensor);
  const Patches patches(skin, side_mm(sensor));
  Scene scene;
  for (const Touch& touch : touches) {
    if (touch.force_N <= 0) continue;
    scene.contacts.push_back(contact_of(sensor, patches, touch, pressure_kPa));
  }
  scene.patches = PatchField{skin.patches, patches.width(), VectorXd(pressure_kPa.size())};
  for (Eigen::Index p = 0; p < pressure_kPa.size(); ++p) {
    scene.patches->ratio[p] = conductivity_ratio(skin.law, pressure_kPa[p]);
  }
  return scene;
}

Scene still_scene(const Sensor& sensor, std::span<const Touch> touches) {
  return skin_scene(sensor, touches, relaxed_pressure_kPa(sensor, touches));
}

FoamMemory::FoamMemory(const Foam& foam, VectorXd relaxed_kPa)
    : foam_(foam), relaxed_(std::move(relaxed_kPa)), remembered_(relaxed_) {}

void FoamMemory::advance(double seconds, const VectorXd& relaxed_kPa) {
  const double steps = foam_.relaxation_s > 0 ? seconds / foam_.relaxation_s : 0;
  if (foam_.relaxation_s <= 0) {
    remembered_ = relaxed_kPa;
  } else if (steps > 0) {
    // Exact for a relaxed pressure that is linear in time.
    const double kept = std::exp(-steps);
    const double lag = -std::expm1(-steps) / steps;  // (1 - exp(-r)) / r
    remembered_ = kept * remembered_ + (lag - kept) * relaxed_ + (1 - lag) * relaxed_kPa;
  }
  relaxed_ = relaxed_kPa;
}

VectorXd FoamMemory::pressure_kPa() const {
  return foam_.prompt_share * relaxed_ + (1 - foam_.prompt_share) * remembered_;
}

}  // namespace ertbench
