//! The message types as they are declared, for other languages' generators.

macro_rules! files {
    ($($name:literal,)*) => {
        &[$((concat!($name, ".lcm"), include_str!(concat!("../types/", $name, ".lcm"))),)*]
    };
}

/// Names and texts of the files of `types/`.
pub const TYPE_FILES: &[(&str, &str)] = files![
    "controller_status_t",
    "node_status_t",
    "object_pose_t",
    "robot_command_t",
    "robot_state_t",
    "sensor_deflection_t",
    "sim_link_motion_t",
    "sim_tool_motion_t",
    "sim_truth_t",
    "task_t",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_there() {
        let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/types");
        let files = std::fs::read_dir(directory).unwrap();
        let mut names: Vec<_> = files
            .map(|file| file.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(
            names,
            TYPE_FILES.iter().map(|(name, _)| *name).collect::<Vec<_>>()
        );
    }
}
