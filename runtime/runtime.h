#pragma once

#include <memory>
#include <span>
#include <string>

/// Fitted solvers in a program of one's own: from the voltages of a frame to the image of what
/// presses, and to its contacts. Needs nothing but the standard library.
///
///     ertbench::runtime::Solver solver = ertbench::runtime::Solver::load("lean-net-8");
///     solver.set_reference(untouched);
///     solver.reconstruct(voltages, image);
///     std::array<ertbench::runtime::Contact, 8> contacts;
///     const int count = solver.contacts(image, contacts);
///
/// `ertbench export NAME --to runtime --out DIR` writes the file. Images are those of the program
/// to 1e-5 of the background.
namespace ertbench::runtime {

struct Contact {
  float x_mm = 0;  ///< from the origin of the sheet's domain
  float y_mm = 0;
  float strength = 0;  ///< integral of the change of the conductivity over the contact, S/m mm2
  float peak = 0;      ///< largest change, S/m
  float area_mm2 = 0;
};

/// A fitted solver. It serves one caller at a time: take one for each thread, or several calls of
/// `load`. Nothing is allocated after `load`, and the time of a frame does not depend on what it
/// shows but for `contacts`, which grows with the pixels above the threshold, for an `lmmse` of
/// several components, of which those count that a frame is likely of, and for a front,
/// which the file has for a network that is told of dead electrodes or by `export --front`: frames
/// with dead electrodes take longer, the first of them longest.
class Solver {
 public:
  /// Loads the file `name`, or NAME.ert in `folder`. Throws std::runtime_error that names the file
  /// if there is none, or it is damaged or of another version.
  static Solver load(const std::string& name, const std::string& folder = ".");

  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;
  ~Solver();

  const std::string& name() const;
  int channels() const;  ///< voltages of a frame, in the order of the sensor's channels
  int rows() const;      ///< of the image, from the least y on
  int columns() const;   ///< from the least x on

  /// Takes the voltages [channels] V of a frame, or a mean of frames, in which nothing presses.
  /// Until then it is those of the sensor's model. Throws std::invalid_argument for another size.
  void set_reference(std::span<const float> voltages);

  /// Writes the change of the conductivity [rows * columns] S/m for the voltages [channels] V of a
  /// frame. Voltages that are no numbers give pixels that are none. Throws std::invalid_argument
  /// for other sizes.
  void reconstruct(std::span<const float> voltages, std::span<float> image);

  /// Writes contacts, the strongest first and at most eight, and returns their number: what stands
  /// above a share of the image's largest change, divided where a saddle is low. The rule is the
  /// one that was chosen when the solver was exported. Throws std::invalid_argument if the image
  /// [rows * columns] has another size.
  int contacts(std::span<const float> image, std::span<Contact> contacts);

 private:
  struct State;
  explicit Solver(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Calls `read(voltages)` until it returns false, and `write(contacts, image)` after each frame.
/// Both get spans that are valid during the call. Nothing is allocated between frames.
template <typename Read, typename Write>
void stream(Solver& solver, Read&& read, Write&& write) {
  const auto pixels = static_cast<std::size_t>(solver.rows() * solver.columns());
  const auto channels = static_cast<std::size_t>(solver.channels());
  const auto voltages = std::make_unique<float[]>(channels);
  const auto image = std::make_unique<float[]>(pixels);
  Contact contacts[8];
  while (read(std::span<float>(voltages.get(), channels))) {
    solver.reconstruct({voltages.get(), channels}, {image.get(), pixels});
    const int count = solver.contacts({image.get(), pixels}, contacts);
    write(std::span<const Contact>(contacts, static_cast<std::size_t>(count)),
          std::span<const float>(image.get(), pixels));
  }
}

}  // namespace ertbench::runtime
