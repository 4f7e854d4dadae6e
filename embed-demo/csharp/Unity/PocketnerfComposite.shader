// A radiance field's picture before and behind polygons, by depth along the camera's axis.
Shader "Pocketnerf/Composite"
{
    Properties { _MainTex ("Polygons", 2D) = "black" {} }
    SubShader
    {
        Cull Off ZWrite Off ZTest Always
        Pass
        {
            CGPROGRAM
            #pragma vertex vert_img
            #pragma fragment frag
            #include "UnityCG.cginc"

            sampler2D _MainTex, _CameraDepthTexture, _FieldColor, _FieldDepth;
            float _FieldScale;

            float4 frag(v2f_img at) : SV_Target
            {
                float4 polygon = tex2D(_MainTex, at.uv);
                // Premultiplied; infinitely far where nothing is.
                float4 field = tex2D(_FieldColor, at.uv);
                float fieldZ = _FieldScale * tex2D(_FieldDepth, at.uv).r;
                float polygonZ = LinearEyeDepth(SAMPLE_DEPTH_TEXTURE(_CameraDepthTexture, at.uv));
                return polygonZ < fieldZ ? polygon : field + (1 - field.a) * polygon;
            }
            ENDCG
        }
    }
}
