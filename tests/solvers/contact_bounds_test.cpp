// Contacts at the border of a sheet: where a fit's steps may take them.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "forward/sheet/sensor.h"
#include "solvers/contacts/contact_fit.h"
#include "solvers/contacts/contact_prior.h"
#include "solvers/contacts/contact_search.h"
#include "tests/forward/sensors_testing.h"
#include "tests/solvers/contact_testing.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr Index numbers = EllipticContact::parameters;

EllipticContact anywhere(RandomStream& random) {
  EllipticContact contact;
  contact.centre = {random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2)};
  contact.log_size = random.uniform(-3, -0.7);
  contact.stretch = {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)};
  contact.log_ratio = random.uniform(-1, 1);
  return contact;
}

/// The least distance of a contact's border to the sheet's.
double depth_of(const Sheet& sheet, const EllipticContact& contact) {
  double least = 1;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(contact.angle()).toRotationMatrix();
  const Vector2d axes = contact.half_axes();
  for (int i = 0; i < 2000; ++i) {
    const double t = 2 * std::numbers::pi * i / 2000;
    const Vector2d edge = turn * Vector2d(axes.x() * std::cos(t), axes.y() * std::sin(t));
    least = std::min(least, sheet.depth(contact.centre + edge));
  }
  return least;
}

TEST(ContactBounds, PutContactsBackOntoTheSheet) {
  const Sensor square;
  const Sensor disc = testing::disc();
  for (const Sensor* sensor : {&square, &disc}) {
    const ContactBounds bounds(*sensor->sheet, ContactPrior{}, true);
    for (std::uint64_t i = 0; i < 300; ++i) {
      RandomStream random(5, key_of("bounds"), i, Purpose::noise);
      EllipticContact contact = anywhere(random);
      bounds.keep_inside(contact);
      EXPECT_GT(depth_of(*sensor->sheet, contact), 0.005) << i;
    }
  }
}

/// A step that the border is in the way of is the best of those that respect it: no step that was
/// drawn near it both stays inside and has a lower value of the quadratic model.
TEST(ContactBounds, StepsAlongTheBorderAreTheBestOfThem) {
  const Sensor sensor;
  const ContactBounds bounds(*sensor.sheet, ContactPrior{}, true);
  int bound = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    RandomStream random(6, key_of("steps"), i, Purpose::noise);
    EllipticContact contact = anywhere(random);
    bounds.keep_inside(contact);
    // Steps of a few hundredths, near which the border of an ellipse is nearly linear.
    MatrixXd square(numbers, numbers);
    VectorXd gradient(numbers);
    for (Index r = 0; r < numbers; ++r) {
      for (Index c = 0; c < numbers; ++c) square(r, c) = random.normal();
      gradient[r] = 0.03 * random.normal();
    }
    const MatrixXd curvature =
        square.transpose() * square / numbers + 0.5 * MatrixXd::Identity(numbers, numbers);
    const Eigen::LLT<MatrixXd> factor(curvature);
    const auto value = [&](const VectorXd& s) {
      return gradient.dot(s) + s.dot(curvature * s) / 2;
    };
    const auto depth_after = [&](const VectorXd& s) {
      return depth_of(*sensor.sheet, EllipticContact::from(contact.vector() + s));
    };
    const VectorXd free = -factor.solve(gradient);
    const VectorXd step = bounds.step({&contact, 1}, factor, gradient);
    if (depth_after(free) > 0.0081) {
      EXPECT_LT((step - free).norm(), 1e-12) << i;
      continue;
    }
    ++bound;
    EXPECT_NEAR(depth_after(step), 0.008, 5e-4) << i;
    for (int other = 0; other < 300; ++other) {
      VectorXd near = step;
      for (double& entry : near) entry += 0.01 * random.normal();
      if (depth_after(near) < 0.0085) continue;
      EXPECT_GT(value(near), value(step) - 1e-5) << i;
    }
  }
  EXPECT_GT(bound, 8);
}

TEST(ContactBounds, DiscsAtTheBorderStayDiscs) {
  const Sensor sensor;
  ContactFit::Options options;
  options.ellipses = false;
  const ContactFit fit(sensor, ContactPrior{},
                       whitening_of(sensor, testing::noise_at(50), Nuisances{}), options);
  for (std::uint64_t frame = 1; frame <= 10; ++frame) {
    ContactFit::Workspace workspace;
    ContactFit::Found found;
    fit.fit(
        testing::pair_means(testing::frame_of({{testing::disc(0, 0.798, 0.2, 0.6)}}, 50, frame)),
        workspace, found);
    for (const EllipticContact& contact : found.best.contacts) {
      EXPECT_EQ(contact.stretch.norm(), 0) << frame;
      EXPECT_GT(depth_of(*sensor.sheet, contact), 0.005) << frame;
    }
  }
}

/// A disc that touches the border of the sheet is found in hardly more iterations than one in the
/// middle: it slides along the border. (That close its mirror image is not resolved by the points
/// of a fit, so that some frames get a faint second contact.)
TEST(ContactBounds, ADiscAtTheBorderTakesFewIterations) {
  const double snr_db = 50;
  const Sensor sensor;
  const ContactFit fit(sensor, ContactPrior{},
                       whitening_of(sensor, testing::noise_at(snr_db), Nuisances{}), {});
  const auto iterations = [&](double x, double y) {
    int sum = 0;
    for (std::uint64_t frame = 1; frame <= 20; ++frame) {
      ContactFit::Workspace workspace;
      ContactFit::Found found;
      fit.fit(
          testing::pair_means(testing::frame_of({{testing::disc(x, y, 0.2, 0.6)}}, snr_db, frame)),
          workspace, found);
      EXPECT_GE(found.best.contacts.size(), 1U);
      sum += found.iterations;
    }
    return sum / 20.0;
  };
  // Putting it back after each step alone takes two and a half times as many.
  const double middle = iterations(0.1, 0.2);
  EXPECT_LT(iterations(0.3, -0.792), 2 * middle);
  EXPECT_LT(iterations(0.795, 0.1), 1.2 * middle);
}

}  // namespace
}  // namespace ertbench
