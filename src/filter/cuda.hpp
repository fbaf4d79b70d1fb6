// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"
#include "filter/filter.hpp"
#include "observation/projection/model.hpp"

namespace stereogrid {

/// Parameters that change from step to step; the host writes them, kernels read them from device memory.
struct FilterMotion {
  FilterStep step;
  float dt_s;
  double cells_per_mps;  ///< dt over the size of a cell
  int moved_x;           ///< whole cells by which the window has moved on
  int moved_y;
};

/// `before`: geometry of the window at the step before.
FilterMotion filter_motion(const FilterInput& input, const GridGeometry& before);

/// The filter's state on the device. Masses are as they arrived; what the update made of them, m(k) = scale·mass(k) +
/// birth(k), is worked out where they are read next: so a step reads and writes each of them once.
struct FilterStateOnDevice {
  /// All bits are 0.
  FilterStateOnDevice(Cuda& cuda, const FilterConfig& config, int cells);

  /// Calls work(data, size) for all that the state consists of.
  template <class Work>
  void for_each_array(const Work& work) {
    work(mass.data(), mass.size());
    work(slots.data(), slots.size());
    for (DeviceImage<float>* image : {&scale, &birth_static, &birth_moving, &occupancy, &standing, &age_s}) {
      work(image->data(), image->size());
    }
  }

  DeviceBuffer<float> mass;  ///< tay2008: [k][cell]; joint: [slot][k][cell of the block]
  DeviceBuffer<int> slots;   ///< joint: of each block; negative: none. Behind them, how many are used, and were before
                             ///< the last ones were given away.
  DeviceImage<float> scale;
  DeviceImage<float> birth_static;
  DeviceImage<float> birth_moving;
  DeviceImage<float> occupancy;
  DeviceImage<float> standing;  ///< joint
  DeviceImage<float> age_s;
};

/// As GridLayers, on the device, one behind the other.
class LayersOnDevice {
 public:
  static constexpr std::size_t layers{8};
  static constexpr std::size_t floats_of(int width, int height) {
    return layers * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  /// Layers in foreign `memory`, of floats_of; none: in their own.
  LayersOnDevice(int width, int height, float* memory = nullptr);

 private:
  LayersOnDevice(int width, int height, float* memory, std::size_t own_floats);

  DeviceBuffer<float> own_;

 public:
  DeviceImage<float> occupancy;
  DeviceImage<float> velocity_x;
  DeviceImage<float> velocity_y;
  DeviceImage<float> age_s;
  DeviceImage<float> velocity_xx;
  DeviceImage<float> velocity_xy;
  DeviceImage<float> velocity_yy;
  DeviceImage<float> moving;
};

/// Tables and working memory of the filter, on the device; allocated and uploaded once.
struct FilterOnDevice {
  FilterOnDevice(Cuda& cuda, const FilterConfig& config, const FilterTables& tables, int cells);

  FilterModel model;
  int side;  ///< side of the lattice
  DeviceBuffer<float> likelihood;
  DeviceBuffer<double> speed_mps;         ///< (side) of the lattice's columns, and of its rows
  DeviceBuffer<float> rounded_speed_mps;  ///< the same
  DeviceBuffer<Antecedents> from;         ///< by velocity
  DeviceImage<float4> prepared;           ///< by cell of the last state
  // joint
  int capacity;                  ///< blocks that can have masses at a time
  float each_moving;             ///< see FilterTables
  MovingFrom moving_from;        ///< likewise
  DeviceImage<float> even;       ///< FilterWorkspace::even
  DeviceImage<float> spread;     ///< FilterWorkspace::spread
  DeviceBuffer<CellBox> moving;  ///< by block of the last state: its moving cells
  DeviceBuffer<int> starts;      ///< by evidence: starts a moving cell whose block has no masses
};

/// All cells unknown; `motion` is on the device, its priors are used.
void reset(Cuda& cuda, const FilterOnDevice& filter, const FilterMotion* motion, FilterStateOnDevice& state);

/// `filter` of filter.hpp, in the forms joint and tay2008, equal to the CPU to the bit; `motion` is on the device.
void filter(Cuda& cuda, FilterOnDevice& filter, const FilterMotion* motion, View<const float, Device> observed,
            const FilterStateOnDevice& before, FilterStateOnDevice& after, LayersOnDevice& layers);

/// `weigh_velocities` of filter.hpp, equal to the CPU to the bit; after filter(). `evidence` and `count` are on the
/// device, or in pinned memory.
void weigh_velocities(Cuda& cuda, FilterOnDevice& filter, const VelocityEvidence* evidence, const int* count,
                      FilterStateOnDevice& state, LayersOnDevice& layers);

/// `resample` of filter.hpp: the window's layers in the cells of the vehicle's grid; equal to the CPU to the bit. The
/// pointers are on the device: where the window lies, and the vehicle's grid in the world.
void resample(Cuda& cuda, const LayersOnDevice& world, const GridGeometry* window,
              const GridInVehicle* vehicle_in_world, LayersOnDevice& vehicle);

/// `correct_by_frame` of filter.hpp, likewise. `cells`: the vehicle's grid in the vehicle frame.
void correct_by_frame(Cuda& cuda, const LayersOnDevice& world, const GridGeometry* window, const GridInVehicle* cells,
                      const GridInVehicle* vehicle_in_world, View<const float, Device> observed, bool is_widened,
                      LayersOnDevice& vehicle);

/// `complete_unobserved` of filter.hpp, likewise.
void complete_unobserved(Cuda& cuda, const LayersOnDevice& world, const GridGeometry* window,
                         const GridInVehicle* vehicle_in_world, LayersOnDevice& vehicle);

}  // namespace stereogrid
