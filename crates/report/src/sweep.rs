//! Presents the runs of a sweep: CSV, and one figure.

mod figure;

use lab::sweep::Plan;
use lab::{Column, Kind, Value};

use crate::table::csv_line;

pub use self::figure::Figure;

/// The first line of the table of runs, with the names of its columns.
pub fn header(plan: &Plan) -> String {
    csv_line(plan.columns().into_iter().map(|column| column.name))
}

/// A row of the table of runs as a line of CSV.
pub fn row(values: &[Value]) -> String {
    csv_line(values.iter().map(ToString::to_string))
}

/// Reads the value of a column from a field of CSV; `None` if it is not of the kind of the column.
pub fn read(column: &Column, field: &str) -> Option<Value> {
    if field.is_empty() {
        return Some(Value::Absent);
    }
    match column.kind {
        Kind::Number => field.parse().ok().map(Value::Number),
        Kind::Count => field.parse().ok().map(Value::Count),
        Kind::Flag => field.parse().ok().map(Value::Flag),
        Kind::Text => Some(Value::Text(field.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use lab::sweep::{Axis, Measure};

    use super::*;

    /// A plan of two axes.
    pub(super) fn plan() -> Plan {
        let axis = |text| Axis::parse(text).unwrap();
        Plan {
            axes: vec![
                axis("springs[0].stiffness_n_m=1,10,100"),
                axis("method=explicit_euler,runge_kutta_4"),
            ],
            seconds: 1.0,
            measures: vec![Measure::Survives, Measure::LargestSpeed],
        }
    }

    #[test]
    fn a_row_is_read_as_it_was_written() {
        let plan = plan();
        let values = vec![
            Value::Count(3),
            Value::Number(10.0),
            Value::Text("runge_kutta_4".to_owned()),
            Value::Text("finished".to_owned()),
            Value::Text("why, \"so\"".to_owned()),
            Value::Number(1.0),
            Value::Flag(true),
            Value::Number(0.1),
            Value::Absent,
        ];
        assert_eq!(
            header(&plan),
            "run,springs[0].stiffness_n_m,method,outcome,why,simulated_s,survives,survived_s,largest_speed_m_s\n"
        );
        assert_eq!(
            row(&values),
            "3,1e1,runge_kutta_4,finished,\"why, \"\"so\"\"\",1e0,true,1e-1,\n"
        );
        let fields = values.iter().map(ToString::to_string);
        let again: Vec<_> = plan
            .columns()
            .iter()
            .zip(fields)
            .map(|(column, field)| read(column, &field).unwrap())
            .collect();
        assert_eq!(again, values);
        assert_eq!(read(&plan.columns()[0], "x"), None);
    }
}
