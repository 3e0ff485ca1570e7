//! Animations: channels of keys, and their values at a time (glTF 2.0, section 3.11 and appendix C).

use gltf::Document;
use rt_math::transcendental::{atan2, sin};
use serde::Deserialize;
use serde_json::Value;

use super::{
    accessor::read_vectors,
    attribute_rules::unpaired_weights,
    buffers::Buffers,
    node_pose::{Pose, Property},
};
use crate::error::ErrorAt;
use crate::parser_message::plain;
use crate::{LoadError, LoadErrorKind, LoadOptions, Model, Warning};

/// An animation as the file has it. The `gltf` crate insists on targets that extensions replace.
#[derive(Deserialize)]
struct AnimationJson {
    channels: Vec<AnimationChannel>,
    samplers: Vec<AnimationSampler>,
}

#[derive(Deserialize)]
struct AnimationChannel {
    sampler: usize,
    target: ChannelTarget,
}

#[derive(Deserialize)]
struct ChannelTarget {
    node: Option<usize>,
    path: String,
}

#[derive(Deserialize)]
struct AnimationSampler {
    input: usize,
    #[serde(default)]
    interpolation: CurveInterpolation,
    output: usize,
}

/// Interpolation between two keys.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum CurveInterpolation {
    Step,
    #[default]
    Linear,
    CubicSpline,
}

/// Poses of a model when the shutter opens and, if an animation runs meanwhile, when it closes. `animations` is the list in the
/// file. Channels of steps hold the pose of the opening.
pub(super) fn poses(
    document: &Document,
    animations: &Value,
    buffers: &Buffers<'_>,
    options: &LoadOptions,
    model: &mut Model,
) -> Result<(Pose, Option<Pose>), LoadError> {
    let list = animations.as_array().map_or(&[][..], Vec::as_slice);
    let mut opens = Pose::rest(document);
    let Some([opens_at, closes_at]) = options.shutter_interval() else {
        if !list.is_empty() {
            model.notes.push("The model is animated: it is shown in its rest pose.".to_owned());
        }
        return Ok((opens, None));
    };
    if list.is_empty() {
        let message = "the file has no animation: the model is in its rest pose".to_owned();
        model.warnings.push(Warning { place: "animations".to_owned(), message });
        return Ok((opens, None));
    }
    animate(&mut opens, list, [opens_at; 2], buffers, options, Some(&mut model.warnings))?;
    if !(closes_at > opens_at) {
        return Ok((opens, None));
    }
    let mut closes = Pose::rest(document);
    animate(&mut closes, list, [opens_at, closes_at], buffers, options, None)?;
    Ok((opens, Some(closes)))
}

/// Poses a model at the second of two times, in seconds; channels of steps at the first.
fn animate(
    pose: &mut Pose,
    list: &[Value],
    [opens_at, time]: [f64; 2],
    buffers: &Buffers<'_>,
    options: &LoadOptions,
    mut warnings: Option<&mut Vec<Warning>>,
) -> Result<(), LoadError> {
    for index in chosen(list, options.animation.as_deref()).at(buffers.path(), "animations")? {
        let place = format!("animations[{index}]");
        let animation = AnimationJson::deserialize(&list[index])
            .map_err(|error| LoadErrorKind::Syntax(plain(&error.to_string())).at(buffers.path(), place.as_str()))?;
        for (c, channel) in animation.channels.iter().enumerate() {
            let place = format!("{place}.channels[{c}]");
            // Without a node the target belongs to an extension.
            let Some(node) = channel.target.node else { continue };
            let Some(property) = Property::of(&channel.target.path) else { continue };
            let sampler = animation.samplers.get(channel.sampler).ok_or_else(|| {
                let rule = format!("is not the index of a sampler; there are {}", animation.samplers.len());
                LoadErrorKind::invalid(channel.sampler, rule).at(buffers.path(), format!("{place}.sampler"))
            })?;
            let curve = Curve::read(sampler, property, buffers, &place)?;
            curve.times.last().into_iter().for_each(|end| options.animation_end.extend(f64::from(*end)));
            if let (Property::Weights, Some(warnings)) = (property, &mut warnings) {
                let message = unpaired_weights(buffers.document().as_json(), node, curve.width);
                warnings.extend(message.map(|message| Warning { place: place.clone(), message }));
            }
            let time = if curve.interpolation == CurveInterpolation::Step { opens_at } else { time };
            pose.set(node, property, &curve.at(time)).at(buffers.path(), format!("{place}.target"))?;
        }
    }
    Ok(())
}

/// The animations that are meant by a name, an index or `all`.
fn chosen(list: &[Value], wanted: Option<&str>) -> Result<Vec<usize>, LoadErrorKind> {
    let Some(wanted) = wanted else { return Ok(vec![0]) };
    let names: Vec<Option<&str>> = list.iter().map(|animation| animation.get("name")?.as_str()).collect();
    if let Some(index) = names.iter().position(|name| *name == Some(wanted)) {
        return Ok(vec![index]);
    }
    match wanted.parse::<usize>() {
        Ok(index) if index < list.len() => Ok(vec![index]),
        _ if wanted == "all" => Ok((0..list.len()).collect()),
        _ => {
            let known = names.iter().enumerate().map(|(i, name)| name.map_or_else(|| i.to_string(), str::to_owned));
            Err(LoadErrorKind::unknown("animation", wanted, known.collect()))
        }
    }
}

/// A property as a function of time.
struct Curve {
    times: Vec<f32>,
    /// `width` numbers for each key; with cubic splines those of the tangent before, the value and the tangent after.
    values: Vec<f32>,
    width: usize,
    interpolation: CurveInterpolation,
    turns: bool,
}

impl Curve {
    fn read(
        sampler: &AnimationSampler,
        property: Property,
        buffers: &Buffers<'_>,
        place: &str,
    ) -> Result<Self, LoadError> {
        let fail = |what: &str, message: String| {
            LoadErrorKind::Syntax(message).at(buffers.path(), format!("{place}: accessors[{what}]"))
        };
        let accessor = |index: usize| buffers.document().accessors().nth(index);
        let (input, output) = (sampler.input.to_string(), sampler.output.to_string());
        let missing = |index: &str| fail(index, "does not exist".to_owned());
        let times = accessor(sampler.input).ok_or_else(|| missing(&input))?;
        let times = read_vectors::<1>(&times, buffers)?.into_flattened();
        if !times.is_sorted_by(|a, b| a < b) || times.iter().any(|time| !time.is_finite()) {
            return Err(fail(&input, "the times of keys must be finite and rise".to_owned()));
        }
        let values = accessor(sampler.output).ok_or_else(|| missing(&output))?;
        let values = match property {
            Property::Translation | Property::Scale => read_vectors::<3>(&values, buffers)?.into_flattened(),
            Property::Rotation => read_vectors::<4>(&values, buffers)?.into_flattened(),
            Property::Weights => read_vectors::<1>(&values, buffers)?.into_flattened(),
        };
        let interpolation = sampler.interpolation;
        let parts = times.len() * if interpolation == CurveInterpolation::CubicSpline { 3 } else { 1 };
        let width = property.width().unwrap_or(values.len() / parts);
        if width == 0 || values.len() != parts * width {
            return Err(fail(&output, format!("has {} numbers, which do not fit {} keys", values.len(), times.len())));
        }
        Ok(Self { times, values, width, interpolation, turns: property == Property::Rotation })
    }

    /// Value at a time; before the first and after the last key, that of the key. Times are compared as `f32`, the precision of
    /// keys: the key of frame 1 at 24 frames per second is later than 1/24 s.
    fn at(&self, time: f64) -> Vec<f64> {
        let after = self.times.partition_point(|key| *key <= time as f32);
        let (Some(before), true) = (after.checked_sub(1), after < self.times.len()) else {
            return self.value(after.saturating_sub(1));
        };
        let [start, end] = [before, after].map(|key| f64::from(self.times[key]));
        let span = end - start;
        let s = ((time - start) / span).clamp(0.0, 1.0);
        let [from, to] = [before, after].map(|key| self.value(key));
        match self.interpolation {
            CurveInterpolation::Step => from,
            CurveInterpolation::Linear if self.turns => slerp(&from, &to, s),
            CurveInterpolation::Linear => mix(&[(&from, 1.0 - s), (&to, s)]),
            CurveInterpolation::CubicSpline => {
                let (s2, s3) = (s * s, s * s * s);
                mix(&[
                    (&from, 2.0 * s3 - 3.0 * s2 + 1.0),
                    (&self.part(3 * before + 2), span * (s3 - 2.0 * s2 + s)),
                    (&to, 3.0 * s2 - 2.0 * s3),
                    (&self.part(3 * after), span * (s3 - s2)),
                ])
            }
        }
    }

    fn value(&self, key: usize) -> Vec<f64> {
        self.part(if self.interpolation == CurveInterpolation::CubicSpline { 3 * key + 1 } else { key })
    }

    fn part(&self, index: usize) -> Vec<f64> {
        self.values[index * self.width..][..self.width].iter().copied().map(f64::from).collect()
    }
}

/// The sum of lists of equal length, each times a factor.
fn mix(terms: &[(&Vec<f64>, f64)]) -> Vec<f64> {
    let sum = |i: usize| terms.iter().map(|(values, factor)| values[i] * factor).sum();
    terms.first().map_or(Vec::new(), |(values, _)| (0..values.len()).map(sum).collect())
}

/// Quaternions along the shorter arc (Shoemake, "Animating Rotation with Quaternion Curves", 1985).
fn slerp(from: &Vec<f64>, to: &Vec<f64>, s: f64) -> Vec<f64> {
    let dot: f64 = from.iter().zip(to).map(|(a, b)| a * b).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    let length = |other: f64| {
        let parts = from.iter().zip(to).map(|(a, b)| b * sign + a * other);
        parts.map(|x| x * x).sum::<f64>().sqrt()
    };
    let angle = 2.0 * atan2(length(-1.0), length(1.0));
    let (before, after) = (sin((1.0 - s) * angle), sin(s * angle));
    if before + after > 0.0 { mix(&[(from, before), (to, sign * after)]) } else { from.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn curve(interpolation: CurveInterpolation, width: usize, values: &[f32]) -> Curve {
        Curve { times: vec![1.0, 2.0, 4.0], values: values.to_vec(), width, interpolation, turns: width == 4 }
    }

    #[test]
    fn keys_hold_or_are_joined_by_lines() {
        let values = [0.0, 10.0, 20.0];
        let (step, line) = (curve(CurveInterpolation::Step, 1, &values), curve(CurveInterpolation::Linear, 1, &values));
        for (time, held, joined) in [
            (-9.0, 0.0, 0.0),
            (1.0, 0.0, 0.0),
            (1.5, 0.0, 5.0),
            (2.0, 10.0, 10.0),
            (3.5, 10.0, 17.5),
            (4.0, 20.0, 20.0),
            (9.0, 20.0, 20.0),
        ] {
            assert_eq!((step.at(time), line.at(time)), (vec![held], vec![joined]), "{time}");
        }
    }

    /// `f32` rounds the times of half of these keys up, and the frame showed the key before.
    #[test]
    fn frames_at_times_of_keys_show_these_keys() {
        let times: Vec<f32> = (0..240).map(|frame| (f64::from(frame) / 24.0) as f32).collect();
        let values: Vec<f32> = (0..240).map(|frame| frame as f32).collect();
        let splines: Vec<f32> = values.iter().flat_map(|value| [0.0, *value, 0.0]).collect();
        for (interpolation, values) in [
            (CurveInterpolation::Step, &values),
            (CurveInterpolation::Linear, &values),
            (CurveInterpolation::CubicSpline, &splines),
        ] {
            let curve = Curve { times: times.clone(), values: values.clone(), width: 1, interpolation, turns: false };
            for frame in 0..240 {
                let (expected, found) = (f64::from(frame), curve.at(f64::from(frame) / 24.0)[0]);
                let tolerance = if interpolation == CurveInterpolation::Step { 0.0 } else { 2e-5 };
                assert!((found - expected).abs() <= tolerance, "{interpolation:?}: {found} at frame {frame}");
            }
        }
    }

    #[test]
    fn splines_have_the_tangents_of_their_keys() {
        // In, value, out: a parabola t² has the tangent 2t, and a cubic spline is exact for it.
        let parabola: Vec<f32> = [1.0f32, 2.0, 4.0].iter().flat_map(|t| [2.0 * t, t * t, 2.0 * t]).collect();
        let spline = curve(CurveInterpolation::CubicSpline, 1, &parabola);
        for time in [1.0, 1.25, 2.0, 2.5, 3.75, 4.0] {
            assert!((spline.at(time)[0] - time * time).abs() < 1e-14, "{time}");
        }
        assert_eq!((spline.at(0.0), spline.at(5.0)), (vec![1.0], vec![16.0]));
    }

    #[test]
    fn turns_run_along_the_shorter_arc() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // Identity, a quarter turn about z with the sign of the longer arc, and that quarter turn again.
        let turn =
            curve(CurveInterpolation::Linear, 4, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, -half, 0.0, 0.0, -half, -half]);
        let third = turn.at(1.0 + 1.0 / 3.0);
        let expected = rt_math::transcendental::tan(std::f64::consts::FRAC_PI_4 / 3.0);
        assert!((third[2] / third[3] - expected).abs() < 1e-7, "{third:?}");
        let same = turn.at(3.0);
        assert!((same[2] / same[3] - 1.0).abs() < 1e-7, "{same:?}");
    }

    #[test]
    fn animations_are_chosen_by_name_index_or_all() {
        let list = [json!({"name": "walk"}), json!({}), json!({"name": "0"})];
        assert_eq!(chosen(&list, None).ok(), Some(vec![0]));
        assert_eq!(chosen(&list, Some("walk")).ok(), Some(vec![0]));
        assert_eq!(chosen(&list, Some("1")).ok(), Some(vec![1]));
        assert_eq!(chosen(&list, Some("0")).ok(), Some(vec![2]), "a name comes first");
        assert_eq!(chosen(&list, Some("all")).ok(), Some(vec![0, 1, 2]));
        let unknown = chosen(&list, Some("wlak")).expect_err("no such").to_string();
        assert_eq!(unknown, "unknown animation `wlak`; did you mean `walk`? Known are `walk`, `1`, `0`");
        assert!(chosen(&list, Some("3")).is_err());
    }
}
