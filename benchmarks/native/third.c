/* A third of a tick by hand: `preview`, servo, motor and gear, catheter in its conduit.
 *
 * The same arithmetic in the same order as the functions named beside each one here, so that the
 * results agree bit for bit; see benchmarks/bench_native.py, which compiles and compares. The
 * records are those of the package, field by field. A spare play has threshold and weight 0.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum { PLAYS = 16, CONDUIT_PLAYS = 12 };

typedef struct {
    double thresholds_mm[PLAYS], weights[PLAYS];
    double slope, offset_mm, curvature_per_mm;
} PlaySum;

typedef struct { double speed_mm_per_s, acceleration_mm_per_s2; } HeadLimits;
typedef struct { double inwards_s, outwards_s; } RunIn;
typedef struct { double head_mm, head_mm_per_s, lag_mm, plays_mm[PLAYS]; } HeadState;

typedef struct {
    double proportional_v, derivative_v_s, velocity_v_s, friction_v, time_constant_s,
        voltage_limit_v;
} Servo;
typedef struct { double error, velocity; } ServoState;

typedef struct {
    double speed_per_v, time_constant_s, voltage_limit_v, friction_v, force_v, encoder_step;
    bool brakes_when_off;
    double polarity;
} DcAxis;
typedef struct { double position, velocity, drive_v; } AxisMotion;

typedef struct {
    double widths_mm[CONDUIT_PLAYS];
    double stretch_mm, gain, gain_per_mm, middle_mm, offset_mm;
    double creep_fast_mm, creep_fast_per_s, creep_slow_mm, creep_slow_per_s;
} Transmission;
typedef struct {
    double plays_mm[CONDUIT_PLAYS];
    double stretch_mm, head_mm, creep_fast_mm, creep_slow_mm, tip_mm;
} TransmissionState;

typedef struct {
    PlaySum plays;
    HeadLimits limits;
    RunIn run_in;
    Servo servo;
    DcAxis axis;
    Transmission transmission;
} Third;
typedef struct {
    HeadState head;
    ServoState servo;
    AxisMotion motion;
    TransmissionState transmission;
} ThirdState;

/* Of two equal numbers the first, as the compiled Python has it. */
static inline double most(double a, double b) { return b > a ? b : a; }
static inline double least(double a, double b) { return b < a ? b : a; }
static inline double clamped(double x, double low, double high) { return least(most(x, low), high); }

/* hysteresis.play.step */
static inline double play(double half_mm, double position_mm, double head_mm)
{
    return clamped(position_mm, head_mm - half_mm, head_mm + half_mm);
}

/* hysteresis.prandtl_ishlinskii: the sum v, and tip positions from and to it */
static inline double inner_mm(const PlaySum *model, const double *positions_mm, double head_mm)
{
    double total = model->slope * head_mm;
    for (int j = 0; j < PLAYS; j++)
        total += model->weights[j] * positions_mm[j];
    return total;
}

static inline double output_mm(const PlaySum *model, const double *positions_mm, double head_mm)
{
    double inner = inner_mm(model, positions_mm, head_mm);
    return model->offset_mm + inner * (1.0 + model->curvature_per_mm * inner);
}

static inline double straight_mm(const PlaySum *model, double tip_mm)
{
    double above_mm = tip_mm - model->offset_mm;
    double inside = most(1.0 + 4.0 * model->curvature_per_mm * above_mm, 0.0);
    return 2.0 * above_mm / (1.0 + sqrt(inside));
}

/* hysteresis.prandtl_ishlinskii.advance_slope */
static double advance_slope(
    const PlaySum *model, const double *positions_mm, double head_mm, double direction)
{
    double slope = model->slope;
    for (int j = 0; j < PLAYS; j++)
        if (model->thresholds_mm[j] + direction * (positions_mm[j] - head_mm) <= 1e-9)
            slope += model->weights[j];
    return slope * (1.0 + 2.0 * model->curvature_per_mm * inner_mm(model, positions_mm, head_mm));
}

/* hysteresis.prandtl_ishlinskii.inverse_step */
static double inverse_step(
    const PlaySum *model, const double *positions_mm, double head_mm, double target_mm)
{
    double gain_mm = straight_mm(model, target_mm) - inner_mm(model, positions_mm, head_mm);
    if (gain_mm == 0.0)
        return 0.0;
    double direction = copysign(1.0, gain_mm), travel_mm = INFINITY;
    for (int round = 0; round <= PLAYS; round++) {
        double slope = model->slope, needed_mm = fabs(gain_mm);
        for (int j = 0; j < PLAYS; j++) {
            double left_mm = model->thresholds_mm[j] + direction * (positions_mm[j] - head_mm);
            if (left_mm < travel_mm) {
                slope += model->weights[j];
                needed_mm += model->weights[j] * left_mm;
            }
        }
        if (!(slope > 0.0))
            break;
        double nearer_mm = needed_mm / slope;
        if (!(nearer_mm < travel_mm))
            break;
        travel_mm = nearer_mm;
    }
    return isfinite(travel_mm) ? direction * travel_mm : 0.0;
}

/* control.head_path.step */
static double head_path(
    HeadLimits limits, double distance_mm, double target_mm_per_s, double velocity, double dt_s)
{
    double reach = limits.acceleration_mm_per_s2 * dt_s;
    double steps = 2.0 * fabs(distance_mm) / (reach * dt_s);
    double braking = 0.5 * reach * (sqrt(1.0 + 4.0 * steps) - 1.0);
    double closing = least(braking, fabs(distance_mm) / dt_s);
    double wanted = target_mm_per_s + copysign(closing, distance_mm);
    wanted = clamped(wanted, velocity - reach, velocity + reach);
    return clamped(wanted, -limits.speed_mm_per_s, limits.speed_mm_per_s);
}

/* control.preview.lead */
static void lead(const Third *third, HeadState *state, const double demand[4], double dt_s)
{
    const double steepest = 4.0, touch_mm = 0.05, early_mm = 0.5;
    const PlaySum *model = &third->plays;
    double target_mm = demand[0], target_mm_per_s = demand[1];
    double direction = demand[2], starts_in_s = demand[3];
    if (target_mm_per_s == 0.0 && starts_in_s > 0.0) {
        double run_in_s = direction > 0.0 ? third->run_in.inwards_s : third->run_in.outwards_s;
        target_mm += direction * (starts_in_s <= run_in_s ? early_mm : touch_mm);
    }
    double head = state->head_mm, distance, head_mm_per_s;
    double missing_mm = target_mm - output_mm(model, state->plays_mm, head);
    if (missing_mm * direction >= 0.0) {
        distance = inverse_step(model, state->plays_mm, head, target_mm);
        double ahead_mm = target_mm + target_mm_per_s * dt_s;
        double further = inverse_step(model, state->plays_mm, head, ahead_mm);
        head_mm_per_s = (further - distance) / dt_s;
        if (head_mm_per_s * direction < 0.0)
            head_mm_per_s = 0.0;
    } else {
        double slope = advance_slope(model, state->plays_mm, head, direction);
        double per_tip = slope > 0.0 ? least(1.0 / slope, steepest) : steepest;
        distance = missing_mm * per_tip;
        head_mm_per_s = target_mm_per_s * per_tip;
    }
    double velocity =
        head_path(third->limits, distance, head_mm_per_s, state->head_mm_per_s, dt_s);
    if (velocity * direction < 0.0)
        velocity = 0.0;
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
        servo->proportional_v * error + servo->derivative_v_s * (error - state->error) / dt_s;
    double ahead = velocity + servo->time_constant_s * (velocity - state->velocity) / dt_s;
    volts += servo->velocity_v_s * ahead;
    if (velocity > 0.0)
        volts += servo->friction_v;
    else if (velocity < 0.0)
        volts -= servo->friction_v;
    state->error = error;
    state->velocity = velocity;
    return clamped(volts, -servo->voltage_limit_v, servo->voltage_limit_v);
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

/* twin.machine.transmission.step */
static void transmission_step(
    const Transmission *conduit, TransmissionState *state, double head_mm, double dt_s)
{
    double behind = state->stretch_mm, drawn = 0.0;
    if (head_mm != state->head_mm) {
        double total = 0.0;
        for (int j = 0; j < CONDUIT_PLAYS; j++) {
            state->plays_mm[j] = play(0.5 * conduit->widths_mm[j], state->plays_mm[j], head_mm);
            total = j == 0 ? state->plays_mm[0] : total + state->plays_mm[j];
        }
        behind = play(0.5 * conduit->stretch_mm, behind, total / CONDUIT_PLAYS);
        double speed = (behind - state->stretch_mm) / dt_s;
        drawn = speed / (fabs(speed) + 3.0);
    }
    state->creep_fast_mm += conduit->creep_fast_per_s * dt_s *
        (conduit->creep_fast_mm * drawn - state->creep_fast_mm);
    state->creep_slow_mm += conduit->creep_slow_per_s * dt_s *
        (conduit->creep_slow_mm * drawn - state->creep_slow_mm);
    double change = conduit->gain_per_mm * (0.5 * behind - conduit->middle_mm);
    double depth_mm = conduit->gain * behind * (1.0 + change) + conduit->offset_mm;
    state->stretch_mm = behind;
    state->head_mm = head_mm;
    state->tip_mm = depth_mm - state->creep_fast_mm - state->creep_slow_mm;
}

int64_t size_of_third(void) { return sizeof(Third); }
int64_t size_of_state(void) { return sizeof(ThirdState); }

/* Ticks under a demand of reference, its velocity, direction of the next motion and time until it.
 * trace: head command, voltage, encoder and tip of each tick. */
void run(const Third *third, const ThirdState *start, const double (*demand)[4], int64_t ticks,
    double dt_s, double (*trace)[4])
{
    ThirdState state = *start;
    for (int64_t tick = 0; tick < ticks; tick++) {
        double step = third->axis.encoder_step;
        double reading = floor(state.motion.position / step + 0.5) * step;
        lead(third, &state.head, demand[tick], dt_s);
        double volts = servo_v(&third->servo, &state.servo, &state.head, reading, dt_s);
        state.motion = axis_step(&third->axis, state.motion, volts, 0.0, dt_s);
        transmission_step(&third->transmission, &state.transmission, state.motion.position, dt_s);
        trace[tick][0] = state.head.head_mm;
        trace[tick][1] = volts;
        trace[tick][2] = reading;
        trace[tick][3] = state.transmission.tip_mm;
    }
}
