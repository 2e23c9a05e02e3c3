#include "forward/data/dataset_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ertbench::dataset_layout {

std::uint64_t contact_width(const DatasetSpec& spec) {
  return std::max<std::size_t>(1, spec.most_contacts());
}

std::uint64_t effort_columns_of(const DatasetSpec& spec) {
  return std::holds_alternative<ContinuousSheet>(spec.model) ? effort_columns : 0;
}

void pack(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> contact_row,
          Eigen::Ref<Eigen::RowVectorXd> vertex_row) {
  constexpr double absent = std::numeric_limits<double>::quiet_NaN();
  contact_row.setConstant(absent);
  vertex_row.setConstant(absent);
  const Eigen::Index vertex_columns =
      vertex_row.size() / std::max<Eigen::Index>(1, contact_row.size() / contact_columns);
  for (std::size_t k = 0; k < scene.contacts.size(); ++k) {
    const Contact& contact = scene.contacts[k];
    const Eigen::Vector2d centre = contact.centroid();
    auto row = contact_row.segment(static_cast<Eigen::Index>(k) * contact_columns, contact_columns);
    row[0] = static_cast<double>(contact.shape);
    row[1] = centre.x();
    row[2] = centre.y();
    row[6] = contact.conductivity_ratio;
    if (contact.shape != Shape::polygon) {
      row[3] = contact.half_size.x();
      row[4] = contact.half_size.y();
      row[5] = contact.angle;
    }
    for (std::size_t v = 0; v < contact.vertices.size(); ++v) {
      vertex_row.segment<2>(static_cast<Eigen::Index>(k) * vertex_columns +
                            2 * static_cast<Eigen::Index>(v)) = contact.vertices[v].transpose();
    }
  }
}

Scene unpack(const Eigen::Ref<const Eigen::RowVectorXd>& contact_row,
             const Eigen::Ref<const Eigen::RowVectorXd>& vertex_row) {
  Scene scene;
  const Eigen::Index count = contact_row.size() / contact_columns;
  const Eigen::Index vertex_columns = vertex_row.size() / std::max<Eigen::Index>(1, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto row = contact_row.segment(k * contact_columns, contact_columns);
    if (!(row[0] >= 0 && row[0] <= 3)) continue;
    Contact contact;
    contact.shape = static_cast<Shape>(static_cast<int>(row[0]));
    contact.centre = {row[1], row[2]};
    contact.conductivity_ratio = row[6];
    if (contact.shape == Shape::polygon) {
      const auto vertices = vertex_row.segment(k * vertex_columns, vertex_columns);
      for (Eigen::Index v = 0; v + 1 < vertex_columns && std::isfinite(vertices[v]); v += 2) {
        contact.vertices.emplace_back(vertices[v], vertices[v + 1]);
      }
      if (contact.vertices.size() < 3) continue;
    } else {
      contact.half_size = {row[3], row[4]};
      contact.angle = row[5];
    }
    scene.contacts.push_back(std::move(contact));
  }
  return scene;
}

void pack_forces(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> row) {
  row.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < scene.contacts.size(); ++k) {
    row[static_cast<Eigen::Index>(k)] = scene.contacts[k].force_N;
  }
}

void unpack_forces(const Eigen::Ref<const Eigen::RowVectorXd>& row, Scene& scene) {
  const auto known = std::min(row.size(), static_cast<Eigen::Index>(scene.contacts.size()));
  for (Eigen::Index k = 0; k < known; ++k) {
    if (row[k] > 0) scene.contacts[static_cast<std::size_t>(k)].force_N = row[k];
  }
}

}  // namespace ertbench::dataset_layout
