// SPDX-License-Identifier: MIT
/// @file  Components behind one interface a role, and the stack of them: tests on many components are compiled once, and a
///        component once for all of them. Held in place, because flight tests count allocations.
#pragma once
#include <cstddef>
#include <new>
#include <type_traits>

#include "gyrostat/flight/stack.hpp"

namespace gyrostat::test {

/// What is asked of a component of any role.
template <class Role>
struct Component {
  virtual ~Component() = default;
  virtual const char* name() const noexcept = 0;
  virtual Traits traits() const noexcept = 0;
  /// How many values its telemetry has.
  virtual long telemetry_values() const noexcept = 0;
  virtual Role* copy_to(void* place) const noexcept = 0;
};

template <class S>
struct NavigatorRole : Component<NavigatorRole<S>> {
  using Scalar = S;
  virtual Measurement<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept = 0;
  virtual Measurement<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept = 0;
  virtual bool passes_on() const noexcept = 0;
};

template <class S>
struct ObserverRole : Component<ObserverRole<S>> {
  using Scalar = S;
  virtual Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept = 0;
  virtual Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept = 0;
  virtual Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept = 0;
  virtual void shift_rate(const Vec3<S>& step) noexcept = 0;
};

template <class S>
struct DetectorRole : Component<DetectorRole<S>> {
  using Scalar = S;
  virtual Detection<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x) noexcept = 0;
  virtual Detection<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Allocation<S>& last) noexcept = 0;
};

template <class S>
struct ControllerRole : Component<ControllerRole<S>> {
  using Scalar = S;
  virtual Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                          const Reference<S>& ref) noexcept = 0;
  virtual Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                         const Reference<S>& ref, const Allocation<S>& last) noexcept = 0;
};

template <class S>
struct AllocatorRole : Component<AllocatorRole<S>> {
  using Scalar = S;
  virtual void reset(const Vehicle<S>& vehicle) noexcept = 0;
  virtual Allocation<S> step(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x,
                             const Detection<S>& det) noexcept = 0;
};

/// A component in its role.
template <class T, class Role, class Derived>
struct Model : Role {
  explicit Model(const T& c) noexcept : component(c) {}
  const char* name() const noexcept final { return T::name; }
  Traits traits() const noexcept final { return traits_of<T>(); }
  long telemetry_values() const noexcept final {
    long values = 0;
    component.telemetry([&values](auto, const auto&) { ++values; });
    return values;
  }
  Role* copy_to(void* place) const noexcept final { return new (place) Derived(component); }
  T component;
};

template <Navigator T, class S = typename T::Scalar>
struct NavigatorModel final : Model<T, NavigatorRole<S>, NavigatorModel<T>> {
  using Model<T, NavigatorRole<S>, NavigatorModel<T>>::Model;
  Measurement<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept final {
    return this->component.start(vehicle, y);
  }
  Measurement<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept final {
    return this->component.step(vehicle, y);
  }
  bool passes_on() const noexcept final { return std::same_as<T, NoNavigator<S>>; }
};

template <Observer T, class S = typename T::Scalar>
struct ObserverModel final : Model<T, ObserverRole<S>, ObserverModel<T>> {
  using Model<T, ObserverRole<S>, ObserverModel<T>>::Model;
  Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept final {
    return this->component.start(vehicle, y);
  }
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept final {
    static_assert(noexcept(this->component.start(vehicle, y)) && noexcept(this->component.step(vehicle, y, last)));
    return this->component.step(vehicle, y, last);
  }
  Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept final {
    static_assert(noexcept(skip_interval(this->component, vehicle, y, last)));
    return skip_interval(this->component, vehicle, y, last);
  }
  void shift_rate(const Vec3<S>& step) noexcept final { gyrostat::shift_rate(this->component, step); }
};

template <Detector T, class S = typename T::Scalar>
struct DetectorModel final : Model<T, DetectorRole<S>, DetectorModel<T>> {
  using Model<T, DetectorRole<S>, DetectorModel<T>>::Model;
  Detection<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x) noexcept final {
    return this->component.start(vehicle, x);
  }
  Detection<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Allocation<S>& last) noexcept final {
    static_assert(noexcept(this->component.start(vehicle, x)) && noexcept(this->component.step(vehicle, x, last)));
    return this->component.step(vehicle, x, last);
  }
};

template <Controller T, class S = typename T::Scalar>
struct ControllerModel final : Model<T, ControllerRole<S>, ControllerModel<T>> {
  using Model<T, ControllerRole<S>, ControllerModel<T>>::Model;
  Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                  const Reference<S>& ref) noexcept final {
    return this->component.start(vehicle, x, det, ref);
  }
  Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det, const Reference<S>& ref,
                 const Allocation<S>& last) noexcept final {
    static_assert(noexcept(this->component.start(vehicle, x, det, ref)) &&
                  noexcept(this->component.step(vehicle, x, det, ref, last)));
    return this->component.step(vehicle, x, det, ref, last);
  }
};

template <Allocator T, class S = typename T::Scalar>
struct AllocatorModel final : Model<T, AllocatorRole<S>, AllocatorModel<T>> {
  using Model<T, AllocatorRole<S>, AllocatorModel<T>>::Model;
  void reset(const Vehicle<S>& vehicle) noexcept final { this->component.reset(vehicle); }
  Allocation<S> step(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x,
                     const Detection<S>& det) noexcept final {
    static_assert(noexcept(this->component.reset(vehicle)) && noexcept(this->component.step(vehicle, demand, x, det)));
    return this->component.step(vehicle, demand, x, det);
  }
};

/// The interface of a component's role, and the component behind it.
template <class R, class M>
struct Place {
  using Role = R;
  using Model = M;
};
template <class T, class S = typename T::Scalar>
auto place_of() {
  if constexpr (Navigator<T>) {
    return Place<NavigatorRole<S>, NavigatorModel<T>>{};
  } else if constexpr (Observer<T>) {
    return Place<ObserverRole<S>, ObserverModel<T>>{};
  } else if constexpr (Detector<T>) {
    return Place<DetectorRole<S>, DetectorModel<T>>{};
  } else if constexpr (Controller<T>) {
    return Place<ControllerRole<S>, ControllerModel<T>>{};
  } else {
    return Place<AllocatorRole<S>, AllocatorModel<T>>{};
  }
}
template <class T>
using ModelOf = typename decltype(place_of<T>())::Model;
template <class T>
using RoleOf = typename decltype(place_of<T>())::Role;

inline constexpr std::size_t room_of_a_component = 32768;  ///< bytes

/// How to make a component: at a place, for a setup, with the default parameters of another one (mostly the same).
template <class Role>
struct Maker {
  using S = typename Role::Scalar;
  Role* (*make)(void* place, const Setup<S>& setup, const Setup<S>& parameters_of) noexcept;
};

template <class T>
constexpr Maker<RoleOf<T>> maker_of() {
  using S = typename T::Scalar;
  return {[](void* place, const Setup<S>& setup, const Setup<S>& parameters_of) noexcept -> RoleOf<T>* {
    static_assert(sizeof(ModelOf<T>) <= room_of_a_component && alignof(ModelOf<T>) <= alignof(std::max_align_t));
    return new (place) ModelOf<T>(T(unchecked, setup, typename T::Params(parameters_of)));
  }};
}

/// Any component of a role.
template <class Role>
class Any {
 public:
  using Scalar = typename Role::Scalar;
  Any(Maker<Role> maker, const Setup<Scalar>& setup, const Setup<Scalar>& parameters_of) noexcept
      : role_(maker.make(place_, setup, parameters_of)) {}
  Any(const Any& other) noexcept : role_(other.role_->copy_to(place_)) {}
  Any& operator=(const Any& other) noexcept {
    if (this == &other) return *this;
    role_->~Role();
    role_ = other.role_->copy_to(place_);
    return *this;
  }
  ~Any() { role_->~Role(); }

  const char* name() const noexcept { return role_->name(); }
  Traits traits() const noexcept { return role_->traits(); }
  long telemetry_values() const noexcept { return role_->telemetry_values(); }
  /// The component itself, by its type.
  template <class T>
  T& as() noexcept {
    return static_cast<ModelOf<T>&>(*role_).component;
  }
  template <class T>
  const T& as() const noexcept {
    return static_cast<const ModelOf<T>&>(*role_).component;
  }

 protected:
  alignas(std::max_align_t) std::byte place_[room_of_a_component];
  Role* role_;
};

template <class S>
struct AnyNavigator : Any<NavigatorRole<S>> {
  using Any<NavigatorRole<S>>::Any;
  Measurement<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    return this->role_->start(vehicle, y);
  }
  Measurement<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    return this->role_->step(vehicle, y);
  }
  bool passes_on() const noexcept { return this->role_->passes_on(); }
};

template <class S>
struct AnyObserver : Any<ObserverRole<S>> {
  using Any<ObserverRole<S>>::Any;
  Estimate<S> start(const Vehicle<S>& vehicle, const Measurement<S>& y) noexcept {
    return this->role_->start(vehicle, y);
  }
  Estimate<S> step(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    return this->role_->step(vehicle, y, last);
  }
  Estimate<S> skip(const Vehicle<S>& vehicle, const Measurement<S>& y, const Allocation<S>& last) noexcept {
    return this->role_->skip(vehicle, y, last);
  }
  void shift_rate(const Vec3<S>& step) noexcept { this->role_->shift_rate(step); }
};

template <class S>
struct AnyDetector : Any<DetectorRole<S>> {
  using Any<DetectorRole<S>>::Any;
  Detection<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x) noexcept {
    return this->role_->start(vehicle, x);
  }
  Detection<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Allocation<S>& last) noexcept {
    return this->role_->step(vehicle, x, last);
  }
};

template <class S>
struct AnyController : Any<ControllerRole<S>> {
  using Any<ControllerRole<S>>::Any;
  Demand<S> start(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det,
                  const Reference<S>& ref) noexcept {
    return this->role_->start(vehicle, x, det, ref);
  }
  Demand<S> step(const Vehicle<S>& vehicle, const Estimate<S>& x, const Detection<S>& det, const Reference<S>& ref,
                 const Allocation<S>& last) noexcept {
    return this->role_->step(vehicle, x, det, ref, last);
  }
};

template <class S>
struct AnyAllocator : Any<AllocatorRole<S>> {
  using Any<AllocatorRole<S>>::Any;
  void reset(const Vehicle<S>& vehicle) noexcept { this->role_->reset(vehicle); }
  Allocation<S> step(const Vehicle<S>& vehicle, const Demand<S>& demand, const Estimate<S>& x,
                     const Detection<S>& det) noexcept {
    return this->role_->step(vehicle, demand, x, det);
  }
};

/// The stack itself, of any components. What costs compile time is out of line: any_components.hpp has it compiled elsewhere.
template <class S, class N = NoNavigator<S>, class G = FixedAxes>
class AnyStack : public FlightStack<AnyObserver<S>, AnyDetector<S>, AnyController<S>, AnyAllocator<S>, N, G> {
 public:
  using Flight = FlightStack<AnyObserver<S>, AnyDetector<S>, AnyController<S>, AnyAllocator<S>, N, G>;
  AnyStack(const Setup<S>& setup, const AnyObserver<S>& o, const AnyDetector<S>& d, const AnyController<S>& c,
           const AnyAllocator<S>& a, const N& n, const G& geometry);
  AnyStack(const AnyStack& other);
  AnyStack& operator=(const AnyStack& other);
  ~AnyStack();
  const Allocation<S>& step(const Measurement<S>& y, const Reference<S>& ref = {}) noexcept;
  void reset() noexcept;
};

template <class S, class N, class G>
AnyStack<S, N, G>::AnyStack(const Setup<S>& setup, const AnyObserver<S>& o, const AnyDetector<S>& d,
                            const AnyController<S>& c, const AnyAllocator<S>& a, const N& n, const G& geometry)
    : Flight(unchecked, setup, o, d, c, a, n, geometry) {
  static_assert(Flight::cannot_throw);
}
template <class S, class N, class G>
AnyStack<S, N, G>::AnyStack(const AnyStack& other) = default;
template <class S, class N, class G>
AnyStack<S, N, G>& AnyStack<S, N, G>::operator=(const AnyStack& other) = default;
template <class S, class N, class G>
AnyStack<S, N, G>::~AnyStack() = default;
template <class S, class N, class G>
const Allocation<S>& AnyStack<S, N, G>::step(const Measurement<S>& y, const Reference<S>& ref) noexcept {
  return Flight::step(y, ref);
}
template <class S, class N, class G>
void AnyStack<S, N, G>::reset() noexcept {
  Flight::reset();
}

}  // namespace gyrostat::test
