// SPDX-License-Identifier: MIT
/// @file  Type-erased components: they satisfy the same concepts as real ones, so FlightStack takes either.
///
/// One pointer hop a call, nothing else (style: option C). The scalar of the host is double.
#pragma once
#include <memory>
#include <utility>

#include "gyrostat/core/concepts.hpp"
#include "gyrostat/flight/navigators/none.hpp"
#include "gyrostat/host/telemetry.hpp"

namespace gyrostat::host {

class NavigatorBase : public Reporting {
 public:
  virtual Measurement<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) = 0;
  virtual Measurement<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y) = 0;
  /// True: it changes nothing, and need not be called.
  virtual bool passes_on() const { return false; }
};

class ObserverBase : public Reporting {
 public:
  virtual Estimate<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) = 0;
  virtual Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                                const Allocation<double>& last) = 0;
  virtual Estimate<double> skip(const Vehicle<double>& vehicle, const Measurement<double>& y,
                                const Allocation<double>& last) = 0;
  virtual void shift_rate(const Vec3<double>& step) = 0;
};

class DetectorBase : public Reporting {
 public:
  virtual Detection<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x) = 0;
  virtual Detection<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x,
                                 const Allocation<double>& last) = 0;
};

class ControllerBase : public Reporting {
 public:
  virtual Demand<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                               const Reference<double>& ref) = 0;
  virtual Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                              const Reference<double>& ref, const Allocation<double>& last) = 0;
};

class AllocatorBase : public Reporting {
 public:
  virtual void reset(const Vehicle<double>& vehicle) = 0;
  virtual Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand,
                                  const Estimate<double>& x, const Detection<double>& det) = 0;
};

namespace detail {

/// The telemetry half of every model.
template <class T, class Base>
class Model : public Base {
 public:
  explicit Model(T component) : component_(std::move(component)) {}
  void entries(std::vector<TelemetryEntry>& out) const final { telemetry_entries(component_, out); }
  double* values(double* row) const final { return telemetry_values(component_, row); }

 protected:
  T component_;
};

template <Navigator T>
class NavigatorModel final : public Model<T, NavigatorBase> {
 public:
  using Model<T, NavigatorBase>::Model;
  Measurement<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) final {
    return this->component_.start(vehicle, y);
  }
  Measurement<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y) final {
    return this->component_.step(vehicle, y);
  }
  bool passes_on() const final { return std::same_as<T, NoNavigator<double>>; }
};

template <Observer T>
class ObserverModel final : public Model<T, ObserverBase> {
 public:
  using Model<T, ObserverBase>::Model;
  Estimate<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) final {
    return this->component_.start(vehicle, y);
  }
  Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y,
                        const Allocation<double>& last) final {
    return this->component_.step(vehicle, y, last);
  }
  Estimate<double> skip(const Vehicle<double>& vehicle, const Measurement<double>& y,
                        const Allocation<double>& last) final {
    return skip_interval(this->component_, vehicle, y, last);
  }
  void shift_rate(const Vec3<double>& step) final { gyrostat::shift_rate(this->component_, step); }
};

template <Detector T>
class DetectorModel final : public Model<T, DetectorBase> {
 public:
  using Model<T, DetectorBase>::Model;
  Detection<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x) final {
    return this->component_.start(vehicle, x);
  }
  Detection<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x,
                         const Allocation<double>& last) final {
    return this->component_.step(vehicle, x, last);
  }
};

template <Controller T>
class ControllerModel final : public Model<T, ControllerBase> {
 public:
  using Model<T, ControllerBase>::Model;
  Demand<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                       const Reference<double>& ref) final {
    return this->component_.start(vehicle, x, det, ref);
  }
  Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                      const Reference<double>& ref, const Allocation<double>& last) final {
    return this->component_.step(vehicle, x, det, ref, last);
  }
};

template <Allocator T>
class AllocatorModel final : public Model<T, AllocatorBase> {
 public:
  using Model<T, AllocatorBase>::Model;
  void reset(const Vehicle<double>& vehicle) final { this->component_.reset(vehicle); }
  Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) final {
    return this->component_.step(vehicle, demand, x, det);
  }
};

}  // namespace detail

/// Owns an erased component of one role.
template <class Base>
class Any {
 public:
  using Scalar = double;
  explicit Any(std::unique_ptr<Base> model) : model_(std::move(model)) {}
  const Reporting& reporting() const noexcept { return *model_; }

 protected:
  std::unique_ptr<Base> model_;
};

class AnyNavigator : public Any<NavigatorBase> {
 public:
  explicit AnyNavigator(std::unique_ptr<NavigatorBase> model)
      : Any(std::move(model)), passes_on_(model_->passes_on()) {}
  Measurement<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) {
    return model_->start(vehicle, y);
  }
  Measurement<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y) {
    return model_->step(vehicle, y);
  }
  bool passes_on() const noexcept { return passes_on_; }

 private:
  bool passes_on_;
};

class AnyObserver : public Any<ObserverBase> {
 public:
  using Any::Any;
  Estimate<double> start(const Vehicle<double>& vehicle, const Measurement<double>& y) {
    return model_->start(vehicle, y);
  }
  Estimate<double> step(const Vehicle<double>& vehicle, const Measurement<double>& y, const Allocation<double>& last) {
    return model_->step(vehicle, y, last);
  }
  Estimate<double> skip(const Vehicle<double>& vehicle, const Measurement<double>& y, const Allocation<double>& last) {
    return model_->skip(vehicle, y, last);
  }
  void shift_rate(const Vec3<double>& step) { model_->shift_rate(step); }
};

class AnyDetector : public Any<DetectorBase> {
 public:
  using Any::Any;
  Detection<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x) {
    return model_->start(vehicle, x);
  }
  Detection<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Allocation<double>& last) {
    return model_->step(vehicle, x, last);
  }
};

class AnyController : public Any<ControllerBase> {
 public:
  using Any::Any;
  Demand<double> start(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                       const Reference<double>& ref) {
    return model_->start(vehicle, x, det, ref);
  }
  Demand<double> step(const Vehicle<double>& vehicle, const Estimate<double>& x, const Detection<double>& det,
                      const Reference<double>& ref, const Allocation<double>& last) {
    return model_->step(vehicle, x, det, ref, last);
  }
};

class AnyAllocator : public Any<AllocatorBase> {
 public:
  using Any::Any;
  void reset(const Vehicle<double>& vehicle) { model_->reset(vehicle); }
  Allocation<double> step(const Vehicle<double>& vehicle, const Demand<double>& demand, const Estimate<double>& x,
                          const Detection<double>& det) {
    return model_->step(vehicle, demand, x, det);
  }
};

static_assert(Navigator<AnyNavigator> && Observer<AnyObserver> && Detector<AnyDetector> && Controller<AnyController> &&
              Allocator<AnyAllocator>);

}  // namespace gyrostat::host
