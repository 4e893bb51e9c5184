"""The lever with heyoka and with scipy, as their manuals show. Entrants of ./chart."""

import bisect
import math

import heyoka
import numpy
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

# Angle off the stop after an event [rad], and times that are one instant [s].
ASIDE = 1e-18
INSTANT = 1e-12


class Scene:
    """The lever and the recording, samples joined by straight lines."""

    def __init__(self, lines):
        lines = iter(lines)
        for line in lines:
            name, value = line.split()
            setattr(self, name, float(value))
            if name == "samples":
                break
        self.a = [float(line) for line in lines]
        assert len(self.a) == self.samples
        self.t = [self.start + k / self.rate for k in range(len(self.a))]
        self.slopes = [(b - a) * self.rate for a, b in zip(self.a, self.a[1:])]
        self.end = self.t[-1]
        self.free = (self.stiffness, self.damping)
        self.contact = (self.contact_stiffness, self.contact_damping)

    def place(self, t):
        return max(0, min(bisect.bisect_right(self.t, t) - 1, len(self.slopes) - 1))

    def excitation(self, t):
        k = self.place(t)
        return self.a[k] + (t - self.t[k]) * self.slopes[k]

    def acceleration(self, t, angle, velocity, contact):
        stiffness, damping = contact
        torque = -self.preload - self.unbalance * self.excitation(t) * math.cos(angle)
        return (torque - damping * velocity - stiffness * angle) / self.inertia

    def lift_off_after(self, t):
        """First time from t on at which the preload no longer holds the lever, or None."""
        limit = -self.lift_off
        if self.excitation(t) < limit:
            return t
        for k in range(self.place(t), len(self.slopes)):
            if self.a[k + 1] < limit:
                return max(t, self.t[k] + max(0.0, (limit - self.a[k]) / self.slopes[k]))
        return None


class Spline(Scene):
    """The same with the cubic spline through the samples that scipy offers."""

    def __init__(self, lines):
        super().__init__(lines)
        self.spline = CubicSpline(self.t, self.a)
        self.crossings = [float(t) for t in self.spline.solve(-self.lift_off, extrapolate=False)]

    def excitation(self, t):
        return float(self.spline(t))

    def lift_off_after(self, t):
        if self.excitation(t) < -self.lift_off:
            return t
        falling = (at for at in self.crossings if at > t and self.spline(at, 1) < 0.0)
        return next(falling, None)


def follow(scene, soft, tolerance, advance):
    """Peak angle [rad] by a solver that `advance`s from a state to the stop or to the end.

    advance(t, angle, velocity, contact) returns the same at the stop or the end, and the peak on the way.
    """
    t, angle, velocity = scene.start, scene.rest_angle if soft else 0.0, 0.0
    contact = scene.contact if soft else scene.free
    resting, peak = not soft, angle
    while scene.end - t >= INSTANT:
        if resting:
            t = scene.lift_off_after(t)
            if t is None:
                break
            angle, velocity, resting = ASIDE, 0.0, False
        t, angle, velocity, highest = advance(t, angle, velocity, contact)
        peak = max(peak, highest)
        if scene.end - t < INSTANT:
            break
        if soft:
            contact = scene.contact if velocity < 0.0 else scene.free
            angle = math.copysign(ASIDE, velocity)
        else:
            angle, velocity = ASIDE, -scene.restitution * velocity
            pressed = -scene.acceleration(t, 0.0, 0.0, scene.free)
            # A bounce lower than the tolerance is none.
            resting = 0.5 * velocity * velocity <= pressed * tolerance
    return peak


def scipy_run(scene, soft, tolerance, at_samples):
    """DOP853 with its own events; ended at each sample where `at_samples`."""

    def stop(_t, y, _contact):
        return y[0]

    def turn(_t, y, _contact):
        return y[1]

    stop.terminal, turn.direction = True, -1

    def slope(t, y, contact):
        return y[1], scene.acceleration(t, y[0], y[1], contact)

    def advance(t, angle, velocity, contact):
        highest = -math.inf
        while True:
            until = scene.t[scene.place(t + INSTANT) + 1] if at_samples else scene.end
            got = solve_ivp(slope, (t, until), (angle, velocity), method="DOP853", events=(stop, turn),
                            rtol=tolerance, atol=tolerance, args=(contact,))
            highest = max([highest, got.y[0, -1], *(at[0] for at in got.y_events[1])])
            t, (angle, velocity) = got.t[-1], got.y[:, -1]
            if got.status or scene.end - t < INSTANT:
                return t, angle, velocity, highest

    return follow(scene, soft, tolerance, advance)


class Heyoka:
    """Taylor's method of heyoka, compiled once, from sample to sample with terminal events at the stop."""

    def __init__(self, scene, tolerance):
        angle, velocity = heyoka.make_vars("angle", "velocity")
        a, jerk, stiffness, damping = (heyoka.par[k] for k in range(4))
        torque = (-scene.preload - scene.unbalance * (a + jerk * heyoka.time) * heyoka.cos(angle)
                  - damping * velocity - stiffness * angle)
        self.highest = -math.inf
        self.scene, self.tolerance = scene, tolerance

        def turned(integrator, time, _sign):
            integrator.update_d_output(time)
            self.highest = max(self.highest, integrator.d_output[0])

        self.integrator = heyoka.taylor_adaptive(
            [(angle, velocity), (velocity, torque / scene.inertia)], [0.0, 0.0], tol=tolerance,
            t_events=[heyoka.t_event(angle)],
            nt_events=[heyoka.nt_event(velocity, turned, direction=heyoka.event_direction.negative)])

    def run(self, soft):
        scene, ta = self.scene, self.integrator

        def advance(t, angle, velocity, contact):
            self.highest = -math.inf
            k = scene.place(t + INSTANT)
            ta.reset_cooldowns()
            ta.state[:] = angle, velocity
            ta.pars[2:] = contact
            while True:
                ta.time = t - scene.t[k]
                ta.pars[:2] = scene.a[k], scene.slopes[k]
                outcome = ta.propagate_until(scene.t[k + 1] - scene.t[k])[0]
                t = scene.t[k] + ta.time
                self.highest = max(self.highest, ta.state[0])
                if outcome != heyoka.taylor_outcome.time_limit:
                    return t, 0.0, ta.state[1], self.highest
                k += 1
                t = scene.t[k]
                if k == len(scene.slopes):
                    return t, ta.state[0], ta.state[1], self.highest

        return follow(scene, soft, self.tolerance, advance)


def entrants(scene, spline):
    """Names and runs of both stops."""
    for tolerance in (1e-6, 1e-9, 1e-12, 1e-15):
        integrator = Heyoka(scene, tolerance)
        yield f"heyoka\t{tolerance:g}", lambda it=integrator: [it.run(soft) for soft in (False, True)]
    for at_samples in (True, False):
        for tolerance in (1e-6, 1e-9, 1e-12, 3e-14):
            name = "scipy-samples" if at_samples else "scipy"
            yield f"{name}\t{tolerance:g}", lambda tolerance=tolerance, at_samples=at_samples: [
                scipy_run(scene, soft, tolerance, at_samples) for soft in (False, True)]
    for tolerance in (1e-6, 1e-9, 1e-12):
        yield f"scipy-spline\t{tolerance:g}", lambda tolerance=tolerance: [
            scipy_run(spline, soft, tolerance, False) for soft in (False, True)]
