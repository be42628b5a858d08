function par = $name_parameters()
% Numbers of $name. Written by hysteron export $VERSION.
    par.name = '$name';
    par.program = 'hysteron $VERSION';
    par.title = $TITLE_STRING;
    par.input_unit = $INPUT_UNIT_STRING;
    par.output_unit = $OUTPUT_UNIT_STRING;
//{ range
    % Range of the voltage that the model was identified in.
    par.identified_range = [$RANGE_LOW, $RANGE_HIGH];
//}
//{ inverse
    % Samples that the reference handed to a step is ahead.
    par.preview = $N_PREVIEW;
//}
$NUMBERS
end
