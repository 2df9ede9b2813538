/* A third of a tick by hand: `preview`, servo, motor and gear, catheter in its conduit.
 *
 * The same arithmetic in the same order as the functions named beside each one here, so that the
 * results agree bit for bit; see benchmarks/bench_native.py, which compiles and compares. The
 * records and constants are those of the package: benchmarks/native/layout.py writes them to
 * records.h. A spare play has threshold and weight 0.
 */
#include <math.h>

#include "records.h"

/* Of two equal numbers the first, as the compiled Python has it. */
static inline double most(double a, double b) { return b > a ? b : a; }
static inline double least(double a, double b) { return b < a ? b : a; }
static inline double clamped(double x, double low, double high) { return least(most(x, low), high); }

/* hysteresis.play.step, by half the width */
static inline double play(double half_mm, double position_mm, double head_mm)
{
    return clamped(position_mm, head_mm - half_mm, head_mm + half_mm);
}

/* hysteresis.play_sum: the sum v, found once a tick, and tip positions from and to it */
static inline double inner_mm(const PlaySum *model, const double *positions_mm, double head_mm)
{
    double total = model->slope * head_mm;
    for (int j = 0; j < PLAYS; j++)
        total += model->weights[j] * positions_mm[j];
    return total;
}

static inline double bent_mm(const PlaySum *model, double inner)
{
    return model->offset_mm + inner * (1.0 + model->curvature_per_mm * inner);
}

static inline double straight_mm(const PlaySum *model, double tip_mm)
{
    double above_mm = tip_mm - model->offset_mm;
    double inside = most(1.0 + 4.0 * model->curvature_per_mm * above_mm, 0.0);
    return 2.0 * above_mm / (1.0 + sqrt(inside));
}

/* hysteresis.play_sum.advance_slope */
static double advance_slope(const PlaySum *model, const double *positions_mm, double head_mm,
    double inner, double direction)
{
    double slope = model->slope;
    for (int j = 0; j < PLAYS; j++) {
        double left_mm = model->thresholds_mm[j] + direction * (positions_mm[j] - head_mm);
        slope += left_mm <= ENGAGED_MM ? model->weights[j] : 0.0;
    }
    return slope * (1.0 + 2.0 * model->curvature_per_mm * inner);
}

/* hysteresis.play_sum.inverse_step */
static double inverse_step(const PlaySum *model, const double *positions_mm, double head_mm,
    double inner, double target_mm)
{
    double gain_mm = straight_mm(model, target_mm) - inner;
    if (gain_mm == 0.0)
        return 0.0;
    double direction = copysign(1.0, gain_mm);
    double slope = model->slope, needed_mm = fabs(gain_mm);
    for (int j = 0; j < PLAYS; j++) {
        double left_mm = model->thresholds_mm[j] + direction * (positions_mm[j] - head_mm);
        if (!(left_mm * slope < needed_mm))
            break;
        slope += model->weights[j];
        needed_mm += model->weights[j] * left_mm;
    }
    double travel_mm = slope > 0.0 ? needed_mm / slope : 0.0;
    return isfinite(travel_mm) ? direction * travel_mm : 0.0;
}

/* control.motion_profile.step */
static double head_path(
    const HeadLimits *limits, double distance_mm, double target_mm_per_s, double velocity,
    double dt_s)
{
    double reach = limits->acceleration_mm_per_s2 * dt_s;
    double steps = 2.0 * fabs(distance_mm) / (reach * dt_s);
    double braking = 0.5 * reach * (sqrt(1.0 + 4.0 * steps) - 1.0);
    double closing = least(braking, fabs(distance_mm) / dt_s);
    double wanted = target_mm_per_s + copysign(closing, distance_mm);
    wanted = clamped(wanted, velocity - reach, velocity + reach);
    return clamped(wanted, -limits->speed_mm_per_s, limits->speed_mm_per_s);
}

/* control.preview.aim_ahead */
static Goal aim_ahead(const RunIn *run_in, const double demand[4])
{
    Goal goal = {.target_mm = demand[0], .target_mm_per_s = demand[1], .direction = demand[2]};
    double starts_in_s = demand[3];
    if (goal.target_mm_per_s == 0.0 && starts_in_s > 0.0) {
        double run_in_s = goal.direction > 0.0 ? run_in->inwards_s : run_in->outwards_s;
        goal.target_mm += goal.direction * (starts_in_s <= run_in_s ? EARLY_MM : TOUCH_MM);
    }
    return goal;
}

/* control.preview.is_followed */
static inline bool is_followed(double distance_mm, double missing_mm)
{
    return 0.0 < fabs(distance_mm) && fabs(distance_mm) <= FOLLOWED * fabs(missing_mm);
}

/* control.preview.is_too_far */
static inline bool is_too_far(const Goal *goal, double missing_mm, double head_mm_per_s)
{
    return goal->target_mm_per_s == 0.0 && missing_mm * goal->direction < 0.0 &&
        head_mm_per_s * goal->direction <= 0.0;
}

/* control.preview.lead */
static Ahead lead(double distance_mm, double further_mm, double direction, double dt_s)
{
    double follow_mm_per_s = (further_mm - distance_mm) / dt_s;
    if (follow_mm_per_s * direction < 0.0)
        follow_mm_per_s = 0.0;
    return (Ahead){.distance_mm = distance_mm, .follow_mm_per_s = follow_mm_per_s};
}

/* control.preview.wait */
static Ahead wait(const Goal *goal, double missing_mm, double slope)
{
    double per_tip = slope > 0.0 ? least(1.0 / slope, STEEPEST) : STEEPEST;
    return (Ahead){
        .distance_mm = missing_mm * per_tip, .follow_mm_per_s = goal->target_mm_per_s * per_tip};
}

/* control.preview.pursue */
static double pursue(
    const HeadLimits *limits, Ahead ahead, double direction, double head_mm_per_s, double dt_s)
{
    double velocity =
        head_path(limits, ahead.distance_mm, ahead.follow_mm_per_s, head_mm_per_s, dt_s);
    return velocity * direction < 0.0 ? 0.0 : velocity;
}

/* control.preview.step */
static void preview_step(
    const PlaySum *model, const HeadLimits *limits, HeadState *state, Goal goal, double dt_s)
{
    const double *plays = state->plays_mm;
    double head = state->head_mm, direction = goal.direction, velocity = 0.0;
    if (direction != 0.0) {
        double inner = inner_mm(model, plays, head);
        double missing_mm = goal.target_mm - bent_mm(model, inner);
        if (is_too_far(&goal, missing_mm, state->head_mm_per_s)) {
            double distance = inverse_step(model, plays, head, inner, goal.target_mm);
            direction = is_followed(distance, missing_mm) ? -direction : direction;
        }
        Ahead ahead;
        if (missing_mm * direction >= 0.0) {
            double distance = inverse_step(model, plays, head, inner, goal.target_mm);
            double further = distance;
            if (goal.target_mm_per_s != 0.0) {
                double ahead_mm = goal.target_mm + goal.target_mm_per_s * dt_s;
                further = inverse_step(model, plays, head, inner, ahead_mm);
            }
            ahead = lead(distance, further, direction, dt_s);
        } else {
            ahead = wait(&goal, missing_mm, advance_slope(model, plays, head, inner, direction));
        }
        velocity = pursue(limits, ahead, direction, state->head_mm_per_s, dt_s);
    }
    state->head_mm = head + velocity * dt_s;
    state->head_mm_per_s = velocity;
    for (int j = 0; j < PLAYS; j++)
        state->plays_mm[j] = play(model->thresholds_mm[j], state->plays_mm[j], state->head_mm);
}

/* control.servo.step */
static double servo_v(
    const Servo *servo, ServoState *state, const HeadState *head, double reading, double dt_s)
{
    double error = head->head_mm - reading, velocity = head->head_mm_per_s;
    double volts =
        servo->proportional_v * error + servo->derivative_v_s / dt_s * (error - state->error);
    double lead = velocity + servo->time_constant_s / dt_s * (velocity - state->velocity);
    volts += servo->velocity_v_s * lead;
    if (velocity > 0.0)
        volts += servo->friction_v;
    else if (velocity < 0.0)
        volts -= servo->friction_v;
    double inwards_v =
        servo->friction_v + servo->back_emf_v_s * most(lead, 0.0) + servo->catch_up_v;
    state->error = error;
    state->velocity = velocity;
    return least(clamped(volts, -servo->voltage_limit_v, servo->voltage_limit_v), inwards_v);
}

/* twin.machine.dc_axis.step, its torque on */
static AxisMotion axis_step(
    const DcAxis *axis, AxisMotion motion, double volts, double load_v, double dt_s)
{
    double limit_v = axis->voltage_limit_v, gain = axis->speed_per_v, tau = axis->time_constant_s;
    double supply_v = clamped(axis->polarity * volts, -limit_v, limit_v);
    double wanted_v = supply_v - motion.velocity / gain;
    double drive_v = clamped(wanted_v, -axis->force_v, axis->force_v);
    double net_v = drive_v - load_v, direction;
    if (motion.velocity == 0.0) {
        if (fabs(net_v) <= axis->friction_v)
            return (AxisMotion){motion.position, 0.0, drive_v};
        direction = net_v > 0.0 ? 1.0 : -1.0;
    } else {
        direction = motion.velocity > 0.0 ? 1.0 : -1.0;
    }
    double brake_v = load_v + direction * axis->friction_v;
    AxisMotion moved = {.drive_v = drive_v};
    if (drive_v != wanted_v) {
        double acceleration = gain * (drive_v - brake_v) / tau;
        moved.velocity = motion.velocity + acceleration * dt_s;
        moved.position = motion.position + (motion.velocity + moved.velocity) * 0.5 * dt_s;
    } else {
        double last = motion.velocity + gain * (drive_v - brake_v);
        double decay = exp(-dt_s / tau);
        moved.velocity = last + (motion.velocity - last) * decay;
        moved.position =
            motion.position + last * dt_s + (motion.velocity - last) * tau * (1.0 - decay);
    }
    if (moved.velocity * direction <= 0.0) {
        double share = motion.velocity / (motion.velocity - moved.velocity);
        double rest = motion.position + 0.5 * motion.velocity * share * dt_s;
        return (AxisMotion){rest, 0.0, drive_v};
    }
    return moved;
}

/* kernel.tiny.drop_tiny */
static inline double drop_tiny(double value) { return fabs(value) < TINY ? 0.0 : value; }

/* twin.machine.transmission.step_creep */
static void creep_step(const Creep *creep, CreepState *state, double speed, double dt_s)
{
    double drawn = speed != 0.0 ? speed / (fabs(speed) + CREEP_MM_PER_S) : 0.0;
    double fast_mm = creep->fast_mm * drawn, slow_mm = creep->slow_mm * drawn;
    state->fast_mm =
        drop_tiny(state->fast_mm + creep->fast_per_s * dt_s * (fast_mm - state->fast_mm));
    state->slow_mm =
        drop_tiny(state->slow_mm + creep->slow_per_s * dt_s * (slow_mm - state->slow_mm));
}

/* twin.machine.transmission.step, its other classes left out: the tip is then no number */
static void transmission_step(
    const Transmission *conduit, TransmissionState *state, double head_mm, double dt_s)
{
    double behind = state->behind_mm, speed = 0.0;
    if (head_mm != state->head_mm) {
        double total = 0.0;
        for (int j = 0; j < CONDUIT_PLAYS; j++) {
            state->plays_mm[j] = play(0.5 * conduit->widths_mm[j], state->plays_mm[j], head_mm);
            total = j == 0 ? state->plays_mm[0] : total + state->plays_mm[j];
        }
        behind = play(0.5 * conduit->stretch_mm, behind, total / CONDUIT_PLAYS);
        if (conduit->kind != CONDUIT_OF_PLAYS)
            behind = NAN;
        speed = (behind - state->behind_mm) / dt_s;
    }
    creep_step(&conduit->creep, &state->creep, speed, dt_s);
    double change = conduit->gain_per_mm * (0.5 * behind - conduit->middle_mm);
    double depth_mm = conduit->gain * behind * (1.0 + change) + conduit->offset_mm;
    state->behind_mm = behind;
    state->head_mm = head_mm;
    state->tip_mm = depth_mm - state->creep.fast_mm - state->creep.slow_mm;
}

/* Ticks under a demand of reference, its velocity, direction of the next motion and time until it.
 * trace: head command, voltage, encoder and tip of each tick. */
void run(const Third *third, const ThirdState *start, const double (*demand)[4], int64_t ticks,
    double dt_s, double (*trace)[4])
{
    ThirdState state = *start;
    for (int64_t tick = 0; tick < ticks; tick++) {
        double step = third->axis.encoder_step;
        double reading = floor(state.motion.position / step + 0.5) * step;
        Goal goal = aim_ahead(&third->run_in, demand[tick]);
        preview_step(&third->plays, &third->limits, &state.head, goal, dt_s);
        double volts = servo_v(&third->servo, &state.servo, &state.head, reading, dt_s);
        state.motion = axis_step(&third->axis, state.motion, volts, 0.0, dt_s);
        transmission_step(&third->transmission, &state.transmission, state.motion.position, dt_s);
        trace[tick][0] = state.head.head_mm;
        trace[tick][1] = volts;
        trace[tick][2] = reading;
        trace[tick][3] = state.transmission.tip_mm;
    }
}
