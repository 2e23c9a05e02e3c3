#include <gtest/gtest.h>

#include "bench/score/image_contacts.h"
#include "forward/sheet/rasterise.h"
#include "forward/touch/indenter.h"
#include "forward/touch/touch_distribution.h"

namespace ertbench {
namespace {

/// The true image of one touch, δσ.
Eigen::RowVectorXd image_of(const Sensor& sensor, const Touch& touch) {
  Eigen::VectorXd ratio(sensor.pixels());
  rasterise(still_scene(sensor, {&touch, 1}), sensor.image(), Rasterisation::area, ratio);
  return sensor.background * (ratio.array() - 1).matrix().transpose();
}

// Without noise and with a perfect image what is left is the pixels' share: places within a part of
// the distance between patches, and none at all at the sheet's points of symmetry.
TEST(TouchReading, ATouchIsLocatedToThePixels) {
  Sensor sensor;
  for (const ContactLaw& law : {ContactLaw(FallingLaw{}), ContactLaw(RisingLaw{})}) {
    sensor.skin = Skin{};
    sensor.skin->law = law;
    const PlaceGrid places{9, 9, {20, 20}, {0, 0}};
    for (int place = 0; place < places.count(); ++place) {
      const Touch touch{Indenter{}, places.place_mm(place), 5};
      const Eigen::RowVectorXd change = image_of(sensor, touch);
      const auto contacts = contacts_of_image(sensor, ContactRule{}, change);
      ASSERT_EQ(contacts.size(), 1u) << place;
      const FrameReading reading = frame_reading(sensor, change, contacts);
      // A quarter of the 8.33 mm between patches.
      EXPECT_LT((*reading.centroid25_mm - touch.place_mm).norm(), 8.33 / 4) << place;
      EXPECT_LT((reading.contacts[0].place_mm - touch.place_mm).norm(), 8.33 / 4) << place;
    }
    const Touch middle{Indenter{}, {0, 0}, 5};
    const Eigen::RowVectorXd change = image_of(sensor, middle);
    EXPECT_LT(frame_reading(sensor, change, {}).centroid25_mm->norm(), 1e-9);
  }
}

// What lies under the indenter has the sign of the law.
TEST(TouchReading, PeakAndSumHaveTheSignOfTheLaw) {
  Sensor sensor;
  const Touch touch{Indenter{}, {31, -22}, 5};
  sensor.skin = Skin{};
  const FrameReading falls = frame_reading(sensor, image_of(sensor, touch), {});
  EXPECT_LT(*falls.peak, 0);
  EXPECT_LT(*falls.sum, 0);
  sensor.skin->law = RisingLaw{};
  const FrameReading rises = frame_reading(sensor, image_of(sensor, touch), {});
  EXPECT_GT(*rises.peak, 0);
  EXPECT_GT(*rises.sum, 0);
}

}  // namespace
}  // namespace ertbench
